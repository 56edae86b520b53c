//! Which strikes are held out together: commands that are alike, and sessions.

use std::collections::HashMap;

use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use values::Command;

/// Commands are alike within this share of the speed, and this angle in rad: a robot repeats its own commands better, and commands
/// drawn at random seldom lie so near.
const ALIKE: (f64, f64) = (5e-3, 5e-3);

/// The group of each command: commands that are alike, or joined by such, have one number.
pub(crate) fn settings(commands: &[Command]) -> Vec<usize> {
    let is_alike = |a: &Command, b: &Command| {
        (a.speed - b.speed).abs() <= ALIKE.0 * a.speed.max(b.speed)
            && (a.angle - b.angle).abs() <= ALIKE.1
    };
    let mut by_speed: Vec<usize> = (0..commands.len()).collect();
    by_speed.sort_by(|a, b| commands[*a].speed.total_cmp(&commands[*b].speed));
    // Each command points to an earlier one of its group, the first to itself.
    let mut earlier: Vec<usize> = (0..commands.len()).collect();
    let first = |earlier: &[usize], mut of: usize| {
        while earlier[of] != of {
            of = earlier[of];
        }
        of
    };
    for (place, i) in by_speed.iter().enumerate() {
        let slow = commands[*i].speed;
        let near = by_speed[place + 1..].iter();
        let near = near.take_while(|j| commands[**j].speed * (1.0 - ALIKE.0) <= slow);
        for j in near.filter(|j| is_alike(&commands[*i], &commands[**j])) {
            let (a, b) = (first(&earlier, *i), first(&earlier, *j));
            earlier[a.max(b)] = a.min(b);
        }
    }
    // Whatever a command points to comes before it, and has its number by then.
    for i in 0..earlier.len() {
        earlier[i] = earlier[earlier[i]];
    }
    earlier
}

/// The group of each name.
pub(crate) fn by_name(names: &[&str]) -> Vec<usize> {
    let mut first = HashMap::new();
    let places = names.iter().enumerate();
    places
        .map(|(place, name)| *first.entry(*name).or_insert(place))
        .collect()
}

/// The fold of each item, at most `most`, so that a group stays whole: groups are dealt in an order drawn from the seed.
pub(crate) fn folds(groups: &[usize], most: usize, seed: u64) -> Vec<usize> {
    let mut distinct = groups.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    distinct.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let mut fold_of = vec![0; groups.iter().max().map_or(0, |most| most + 1)];
    for (place, group) in distinct.iter().enumerate() {
        fold_of[*group] = place % most.max(1);
    }
    groups.iter().map(|group| fold_of[*group]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_that_are_alike_stay_together_and_others_do_not() {
        let command = |(speed, angle)| Command { speed, angle };
        let commands = [
            (0.5, 0.1),
            (0.7, 0.1),
            (0.501, 0.101),
            (0.5, -0.1),
            (0.7, 0.1),
        ];
        let groups = settings(&commands.map(command));
        assert_eq!(groups, [0, 1, 0, 3, 1]);
        for seed in 0..20 {
            let folds = folds(&groups, 3, seed);
            assert_eq!((folds[0], folds[1]), (folds[2], folds[4]));
            assert!(folds[0] != folds[1] && folds.iter().all(|fold| *fold < 3));
        }
    }

    #[test]
    fn chains_of_commands_that_are_alike_are_one_group_however_they_are_ordered() {
        // Steps of half of what counts as alike, from two ends to the middle.
        let chain =
            [0, 6, 1, 5, 2, 4, 3].map(|step| Command::new(1.0, 0.5 * ALIKE.1 * f64::from(step)));
        assert_eq!(settings(&chain), [0; 7]);
    }

    #[test]
    fn sessions_are_distinguished_by_their_names() {
        assert_eq!(by_name(&["a", "b", "a", "c", "b"]), [0, 1, 0, 3, 1]);
    }
}
