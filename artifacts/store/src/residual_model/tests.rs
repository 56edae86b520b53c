use safetensors::tensor::{Dtype, TensorView};

use super::launch_map_file::LAUNCH_VERSION;
use super::*;
use crate::launch_map::{FEATURES, LINEAR, Parts, SmoothMap, spectrum};
use crate::network::{LAYERS, Layer, SIZES};

/// Networks whose weights differ from each other: −0.5 … 0.5 in steps of 1/16.
fn model(count: usize) -> ResidualModel {
    let numbers = |count: usize, offset: usize| -> Vec<f32> {
        (0..count)
            .map(|i| ((i * 7 + offset) % 17) as f32 / 16.0 - 0.5)
            .collect()
    };
    let network = |member: usize| {
        let layers = (0..LAYERS)
            .map(|i| Layer {
                weight: numbers(SIZES[i] * SIZES[i + 1], i + member),
                bias: numbers(SIZES[i + 1], i + 3 + member),
            })
            .collect();
        Network::new(layers).expect("shapes are right")
    };
    let networks = Networks::new((0..count).map(network).collect());
    ResidualModel::Networks(networks.expect("a few"))
}

fn map() -> LaunchMap {
    let mut prior = vec![0.01; LINEAR];
    prior.extend(spectrum(0.02, [0.9, 0.7]));
    let part = |offset: usize| SmoothMap {
        weights: (0..FEATURES)
            .map(|i| ((i * 5 + offset) % 11) as f64 * 0.01 - 0.05)
            .collect(),
        covariance: (0..FEATURES * FEATURES)
            .map(|i| if i % (FEATURES + 1) == 0 { 1e-3 } else { 0.0 })
            .collect(),
        prior: prior.clone(),
        scatter: 0.001,
    };
    let parts = Parts {
        centre: [0.7, 0.0],
        half_width: [0.3, 0.8],
        speed: part(0),
        angle: part(4),
    };
    LaunchMap::new(parts).expect("a map")
}

#[test]
fn weights_survive_the_file_bit_by_bit() {
    let bytes = model(1).to_safetensors();
    let read = ResidualModel::from_safetensors(&bytes).expect("own file");
    assert_eq!(read, model(1));
    assert_eq!(read.to_safetensors(), bytes);
}

#[test]
fn damage_is_refused() {
    let bytes = model(1).to_safetensors();
    assert!(matches!(
        ResidualModel::from_safetensors(&bytes[..bytes.len() - 1]),
        Err(ResidualModelError::Network(NetworkError::Format(_)))
    ));
    assert!(matches!(
        ResidualModel::from_safetensors(&[]),
        Err(ResidualModelError::Network(NetworkError::Format(_)))
    ));
    let mut nan = bytes.clone();
    let end = nan.len();
    nan[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(matches!(
        ResidualModel::from_safetensors(&nan),
        Err(ResidualModelError::Network(NetworkError::NotFinite { .. }))
    ));
}

#[test]
fn other_names_and_shapes_are_refused() {
    let data = [0u8; 16];
    let write = |name: &str, shape: Vec<usize>, dtype| {
        let view = TensorView::new(dtype, shape, &data).expect("16 bytes");
        safetensors::serialize([(name, view)], None).expect("one tensor")
    };
    let alone = write("layer0.weight", vec![4], Dtype::F32);
    assert!(matches!(
        ResidualModel::from_safetensors(&alone),
        Err(ResidualModelError::Network(NetworkError::Names { .. }))
    ));

    let whole = model(1).to_safetensors();
    let file = SafeTensors::deserialize(&whole).expect("own file");
    let swapped = file.tensors().into_iter().map(|(name, view)| {
        let shape = view.shape().iter().rev().copied().collect();
        (
            name,
            TensorView::new(Dtype::F32, shape, view.data()).expect("same count"),
        )
    });
    let transposed = safetensors::serialize(swapped, None).expect("eight tensors");
    assert!(matches!(
        ResidualModel::from_safetensors(&transposed),
        Err(ResidualModelError::Network(NetworkError::Shape { .. }))
    ));
}

#[test]
fn either_kind_survives_the_file_and_answers_alike() {
    for model in [model(1), model(4), map().into()] {
        let bytes = model.to_safetensors();
        let read = ResidualModel::from_safetensors(&bytes).expect("own file");
        assert_eq!(read, model);
        assert_eq!(read.to_safetensors(), bytes);
        let text = serde_json::to_string(&model).expect("plain data");
        assert_eq!(
            serde_json::from_str::<ResidualModel>(&text).expect("own text"),
            model
        );
    }
}

#[test]
fn several_networks_answer_with_their_mean() {
    let ResidualModel::Networks(networks) = model(3) else {
        panic!("networks")
    };
    let inputs = [0.3, -0.1, 0.7, 0.2];
    let mean = |i: usize| -> f64 {
        networks
            .each()
            .iter()
            .map(|one| one.predict(inputs)[i])
            .sum::<f64>()
            / 3.0
    };
    let answer = networks.predict(inputs);
    assert!((answer[0] - mean(0)).abs() < 1e-12 && (answer[1] - mean(1)).abs() < 1e-12);
    assert!(Networks::new(Vec::new()).is_err());
}

#[test]
fn a_map_of_another_version_or_with_a_tensor_too_many_is_refused() {
    let bytes = ResidualModel::from(map()).to_safetensors();
    let file = SafeTensors::deserialize(&bytes).expect("own file");
    let version = (LAUNCH_VERSION + 1.0).to_le_bytes();
    let newer = file.tensors().into_iter().map(|(name, view)| {
        if name == "launch.version" {
            let view = TensorView::new(Dtype::F64, vec![1], &version).expect("8 bytes");
            (name, view)
        } else {
            (name, view)
        }
    });
    let newer = safetensors::serialize(newer, None).expect("eleven tensors");
    assert!(matches!(
        ResidualModel::from_safetensors(&newer),
        Err(ResidualModelError::LaunchMap(_))
    ));
    let extra = TensorView::new(Dtype::F64, vec![1], &version).expect("8 bytes");
    let more = file.tensors().into_iter().chain([("x".to_string(), extra)]);
    let more = safetensors::serialize(more, None).expect("twelve tensors");
    assert!(ResidualModel::from_safetensors(&more).is_err());
}
