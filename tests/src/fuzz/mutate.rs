//! Small changes to an input, as disks, cables and people make them, and some of ill will.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

const EDGES: [u64; 14] = [
    0,
    1,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    1 << 40,
    1 << 60,
    u64::MAX - 8,
    u64::MAX,
];

/// Makes one to eight changes.
pub(super) fn mutate(
    input: &mut Vec<u8>,
    corpus: &[Vec<u8>],
    words: &[&str],
    random: &mut ChaCha8Rng,
) {
    for _ in 0..1 << random.random_range(0..4_u32) {
        change(input, corpus, words, random);
    }
}

fn change(input: &mut Vec<u8>, corpus: &[Vec<u8>], words: &[&str], random: &mut ChaCha8Rng) {
    let place = |random: &mut ChaCha8Rng, length: usize| random.random_range(0..=length);
    if input.is_empty() {
        input.push(0);
    }
    let at = random.random_range(0..input.len());
    let end = (at + 1 + random.random_range(0..16_usize)).min(input.len());
    match random.random_range(0..10_u32) {
        0 | 1 => input[at] ^= 1 << random.random_range(0..8_u32),
        2 => input[at] = random.random(),
        3 => drop(input.drain(at..end)),
        4 => {
            let copy = input[at..end].to_vec();
            let to = place(random, input.len());
            input.splice(to..to, copy);
        }
        5 => {
            let edge = EDGES[random.random_range(0..EDGES.len())].to_le_bytes();
            let width = [1, 2, 4, 8][random.random_range(0..4_usize)].min(input.len() - at);
            input[at..at + width].copy_from_slice(&edge[..width]);
        }
        6 => {
            let other = &corpus[random.random_range(0..corpus.len())];
            let from = place(random, other.len());
            let to = (from + random.random_range(0..64_usize)).min(other.len());
            input.splice(at..at, other[from..to].iter().copied());
        }
        7 => {
            // The head of one, the tail of another.
            let other = &corpus[random.random_range(0..corpus.len())];
            let from = place(random, other.len());
            input.truncate(at);
            input.extend_from_slice(&other[from..]);
        }
        8 if !words.is_empty() => {
            let word = words[random.random_range(0..words.len())].bytes();
            input.splice(at..at, word);
        }
        8 => input.truncate(at),
        // A number in a text for another.
        _ => {
            let is_number = |byte: &u8| byte.is_ascii_digit() || b".-+e".contains(byte);
            let Some(from) = input[at..].iter().position(u8::is_ascii_digit) else {
                return;
            };
            let from = at + from;
            let length = input[from..]
                .iter()
                .take_while(|byte| is_number(byte))
                .count();
            let numbers = [
                "0",
                "-1",
                "1e308",
                "1e-320",
                "-0.0",
                "nan",
                "inf",
                "9007199254740993",
                "0.5",
            ];
            let number = numbers[random.random_range(0..numbers.len())].bytes();
            input.splice(from..from + length, number);
        }
    }
}
