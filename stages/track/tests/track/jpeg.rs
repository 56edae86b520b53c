//! Damaged JPEGs: a changed bit, lost bytes, another size. A decoder that falls into step again gives an image that looks well, with the
//! object in another place.

use crate::common::messages::{pictures, small};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use render::Picture;
use track::{Decoder, Image, ImageError, ImageMessage, Payload, Tracker};
use values::Point;

/// A centre farther from the truth than this, in m, is wrong.
const WRONG: f64 = 0.003;

fn decode<'a>(decoder: &'a mut Decoder, data: &[u8]) -> Result<&'a Image, ImageError> {
    let payload = Payload::Compressed(data);
    decoder.decode(&ImageMessage { stamp: 0, payload })
}

fn encoded(picture: &Picture, with: &dyn Fn(&mut Encoder<&mut Vec<u8>>)) -> Vec<u8> {
    let mut data = Vec::new();
    let mut encoder = Encoder::new(&mut data, 90);
    with(&mut encoder);
    let size = [picture.width, picture.height].map(|side| side as u16);
    encoder
        .encode(&picture.rgb, size[0], size[1], ColorType::Rgb)
        .unwrap();
    data
}

#[test]
fn whole_images_of_all_kinds_are_decoded() {
    let mut picture = pictures(&small(), 1).remove(0).1;
    // No whole number of blocks.
    let row = 3 * picture.width;
    picture.height = 101;
    picture.rgb.truncate(101 * row);
    let samplings = [
        SamplingFactor::F_1_1,
        SamplingFactor::F_2_1,
        SamplingFactor::F_1_2,
        SamplingFactor::F_2_2,
        SamplingFactor::F_4_1,
    ];
    let mut decoder = Decoder::default();
    for sampling in samplings {
        for (restarts, optimal, progressive) in [
            (0, false, false),
            (0, true, false),
            (3, false, false),
            (50, false, false),
            (0, false, true),
        ] {
            let data = encoded(&picture, &|encoder| {
                encoder.set_sampling_factor(sampling);
                encoder.set_optimized_huffman_tables(optimal);
                encoder.set_progressive(progressive);
                if restarts > 0 {
                    encoder.set_restart_interval(restarts);
                }
            });
            let what = format!("{sampling:?} {restarts} {optimal} {progressive}");
            let decoded = decode(&mut decoder, &data).map(|image| image.height);
            assert_eq!(decoded, Ok(101), "{what}");
            // Bytes behind the end are no part of it.
            let longer = [&data[..], &[0; 20]].concat();
            assert!(decode(&mut decoder, &longer).is_ok(), "{what}");
        }
    }
}

#[test]
fn an_image_of_a_usb_camera_without_codes_of_its_own_is_decoded_and_checked() {
    let picture = pictures(&small(), 1).remove(0).1;
    let data = encoded(&picture, &|_| {});
    // All segments but those of the codes, which are the standard's.
    let mut segments = Vec::new();
    let mut at = 2;
    while data[at + 1] != 0xda {
        let next = at + 2 + usize::from(u16::from_be_bytes([data[at + 2], data[at + 3]]));
        if data[at + 1] != 0xc4 {
            segments.extend(&data[at..next]);
        }
        at = next;
    }
    let codes = at - 2 - segments.len();
    assert!(codes > 400, "{codes} bytes of codes");
    let mut decoder = Decoder::default();
    let whole = decode(&mut decoder, &data).unwrap().rgb.clone();
    let avi = b"\xff\xe0\x00\x10AVI1\0\0\0\0\0\0\0\0\0\0";
    let mut bare = Vec::new();
    for head in [&avi[..], &[]] {
        bare = [&b"\xff\xd8"[..], head, &segments, &data[at..]].concat();
        assert!(
            decode(&mut decoder, &bare).unwrap().rgb == whole,
            "{head:?}"
        );
    }
    let middle = bare.len() / 2;
    bare.drain(middle..middle + 64);
    assert!(decode(&mut decoder, &bare).is_err(), "64 bytes lost");
}

#[test]
fn what_does_not_fit_its_header_is_refused() {
    let picture = pictures(&small(), 1).remove(0).1;
    let data = encoded(&picture, &|_| {});
    let mut decoder = Decoder::default();
    let mut said = |data: &[u8]| {
        let decoded = decode(&mut decoder, data);
        decoded.map(|image| image.width).unwrap_err().to_string()
    };
    let end = data.len() - 2;
    let middle = end / 2;
    let lost = [&data[..middle], &data[middle + 64..]].concat();
    assert!(said(&lost).contains("JPEG"), "64 bytes lost");
    let cut = [&data[..middle], &[0xff, 0xd9]].concat();
    assert!(said(&cut).contains("before the image does"), "cut");
    let size = data.windows(2).position(|two| two == [0xff, 0xc0]).unwrap() + 5;
    for (pixels, part) in [(232u16, "left over"), (260, "before the image does")] {
        let mut other = data.clone();
        other[size..size + 2].copy_from_slice(&pixels.to_be_bytes());
        let said = said(&other);
        assert!(said.contains(part), "{pixels}: {said}");
    }
    let more = [&data[..end], &[0x12, 0x34], &data[end..]].concat();
    assert!(said(&more).contains("left over"), "more");
    assert!(decode(&mut decoder, &data).is_ok());
}

#[test]
fn no_changed_bit_moves_the_object() {
    let progressive = |encoder: &mut Encoder<&mut Vec<u8>>| encoder.set_progressive(true);
    for (what, encode) in [
        (
            "baseline",
            &(|_: &mut Encoder<&mut Vec<u8>>| {}) as &dyn Fn(&mut Encoder<&mut Vec<u8>>),
        ),
        ("progressive", &progressive),
    ] {
        let rig = small();
        let tracker = Tracker::new(&rig).unwrap();
        let mut decoder = Decoder::default();
        let (mut refused, mut given) = (0, 0);
        for (number, (at, picture)) in pictures(&rig, 10).into_iter().enumerate() {
            let data = encoded(&picture, encode);
            let start = data.windows(2).position(|two| two == [0xff, 0xda]).unwrap() + 14;
            for part in 0..40 {
                let mut data = data.clone();
                let place = start + (data.len() - 2 - start) * part / 40;
                data[place] ^= 1 << ((number + part) % 8);
                let Ok(image) = decode(&mut decoder, &data) else {
                    refused += 1;
                    continue;
                };
                let Ok(centre) = tracker.observe(image).centre else {
                    continue;
                };
                given += 1;
                let off = centre.distance(Point::new(at.x, at.y));
                assert!(off < WRONG, "{what} {number}, byte {place}: {off} m");
            }
        }
        println!("{what}: {refused} of 400 images refused, {given} centres");
        assert!(refused > 200 && given > 0, "{what}: {refused} {given}");
    }
}

/// The first of the pictures, as libjpeg's own script makes it progressive: coefficients come bit by bit.
const REFINED: &[u8] = include_bytes!("../progressive.jpg");

#[test]
fn an_image_whose_coefficients_come_bit_by_bit_is_checked() {
    let rig = small();
    let (at, _) = pictures(&rig, 1).remove(0);
    let tracker = Tracker::new(&rig).unwrap();
    let mut decoder = Decoder::default();
    let whole = tracker.observe(decode(&mut decoder, REFINED).unwrap());
    assert!(whole.centre.is_ok(), "{whole:?}");
    let scan = REFINED.windows(2).position(|two| two == [0xff, 0xda]);
    let places = scan.unwrap() + 14..REFINED.len() - 2;
    let (mut refused, mut given) = (0, 0);
    for place in places.step_by(11) {
        let mut data = REFINED.to_vec();
        data[place] ^= 1 << (place % 8);
        let Ok(image) = decode(&mut decoder, &data) else {
            refused += 1;
            continue;
        };
        if let Ok(centre) = tracker.observe(image).centre {
            given += 1;
            let off = centre.distance(Point::new(at.x, at.y));
            assert!(off < WRONG, "byte {place}: {off} m");
        }
    }
    println!("{refused} images refused, {given} centres");
    assert!(refused > 100 && given > 0, "{refused} {given}");
}
