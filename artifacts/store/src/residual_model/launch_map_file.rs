//! The file of a launch map.

use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};

use super::networks::ResidualModelError;
use crate::launch_map::{FEATURES, LaunchMap, LaunchMapError, Parts, SmoothMap};
use crate::network::NetworkError;

/// Version of a launch map's tensors; raised when one changes its name or meaning.
pub(super) const LAUNCH_VERSION: f64 = 2.0;
/// Its tensors, all f64, and their shapes.
const LAUNCH_TENSORS: [(&str, &[usize]); 11] = [
    ("launch.version", &[1]),
    ("launch.centre", &[2]),
    ("launch.half_width", &[2]),
    ("launch.speed.weights", &[FEATURES]),
    ("launch.speed.covariance", &[FEATURES, FEATURES]),
    ("launch.speed.prior", &[FEATURES]),
    ("launch.speed.scatter", &[1]),
    ("launch.angle.weights", &[FEATURES]),
    ("launch.angle.covariance", &[FEATURES, FEATURES]),
    ("launch.angle.prior", &[FEATURES]),
    ("launch.angle.scatter", &[1]),
];

pub(super) fn map_to_safetensors(map: &LaunchMap) -> Vec<u8> {
    let Parts {
        centre,
        half_width,
        speed,
        angle,
    } = map.parts();
    let of = |map: &SmoothMap| {
        [
            map.weights.clone(),
            map.covariance.clone(),
            map.prior.clone(),
            vec![map.scatter],
        ]
    };
    let mut numbers = vec![vec![LAUNCH_VERSION], centre.to_vec(), half_width.to_vec()];
    numbers.extend(of(speed));
    numbers.extend(of(angle));
    let bytes: Vec<Vec<u8>> = numbers
        .iter()
        .map(|numbers| numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
        .collect();
    let views = LAUNCH_TENSORS
        .iter()
        .zip(&bytes)
        .map(|((name, shape), data)| {
            let view = TensorView::new(Dtype::F64, shape.to_vec(), data);
            (*name, view.expect("a map's lengths are checked"))
        });
    safetensors::serialize(views, None).expect("a header of eleven tensors can be written")
}

/// Reads them; everything is checked.
pub(super) fn map_from_safetensors(file: &SafeTensors) -> Result<LaunchMap, ResidualModelError> {
    let mut found: Vec<String> = file.names().into_iter().map(String::from).collect();
    let mut expected: Vec<String> = LAUNCH_TENSORS.map(|(name, _)| name.to_string()).to_vec();
    found.sort();
    expected.sort();
    if found != expected {
        return Err(NetworkError::Names {
            found: found.join(", "),
            expected: expected.join(", "),
        }
        .into());
    }
    let mut numbers = LAUNCH_TENSORS
        .iter()
        .map(|(name, shape)| read(file, name, shape))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter();
    let mut next = || numbers.next().unwrap_or_default();
    if next() != [LAUNCH_VERSION] {
        return Err(LaunchMapError {
            name: "launch.version",
            why: "is another than this program reads",
        }
        .into());
    }
    let pair = |numbers: Vec<f64>| [numbers[0], numbers[1]];
    let (centre, half_width) = (pair(next()), pair(next()));
    let mut map = || {
        let (weights, covariance, prior) = (next(), next(), next());
        SmoothMap {
            weights,
            covariance,
            prior,
            scatter: next()[0],
        }
    };
    let parts = Parts {
        centre,
        half_width,
        speed: map(),
        angle: map(),
    };
    Ok(LaunchMap::new(parts)?)
}

fn read(file: &SafeTensors, name: &str, shape: &[usize]) -> Result<Vec<f64>, NetworkError> {
    let tensor = file.tensor(name).map_err(NetworkError::Format)?;
    if tensor.dtype() != Dtype::F64 || tensor.shape() != shape {
        return Err(NetworkError::Shape {
            name: name.into(),
            found: format!("{:?} {:?}", tensor.dtype(), tensor.shape()),
            expected: format!("F64 {shape:?}"),
        });
    }
    let (numbers, _) = tensor.data().as_chunks::<8>();
    Ok(numbers
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect())
}
