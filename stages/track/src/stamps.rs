//! Which stamps of a sequence are of no use: those that are not after the one before, and a single one that is ahead of all behind it.

/// Decides stamp by stamp, two behind at the most: where a stamp is not after the one before, it is the next that shows which of the two
/// is wrong.
#[derive(Debug)]
pub(crate) struct Stamps<T> {
    /// The last stamp that is right, in ns. None is before 1970.
    last: i64,
    /// A stamp after the last one, and one behind it that is not after it.
    first: Option<(i64, T)>,
    second: Option<(i64, T)>,
}

impl<T> Stamps<T> {
    pub(crate) fn new() -> Self {
        Self {
            last: -1,
            first: None,
            second: None,
        }
    }

    /// Takes a stamp (ns) and what belongs to it, and gives those that are decided, each with whether its stamp is of no use.
    pub(crate) fn push(&mut self, stamp: i64, item: T, out: &mut dyn FnMut(T, bool)) {
        if let (Some((first, _)), Some((second, _))) = (&self.first, &self.second) {
            let is_first_ahead = self.last < *second && *second < stamp && stamp < *first;
            self.settle(is_first_ahead, out);
        }
        match &self.first {
            Some((first, _)) if stamp <= *first => self.second = Some((stamp, item)),
            None if stamp <= self.last => out(item, true),
            _ => {
                self.settle(false, out);
                self.first = Some((stamp, item));
            }
        }
    }

    /// Gives what is left, at the end.
    pub(crate) fn finish(&mut self, out: &mut dyn FnMut(T, bool)) {
        self.settle(false, out);
    }

    fn settle(&mut self, is_first_ahead: bool, out: &mut dyn FnMut(T, bool)) {
        let waiting = [
            (self.first.take(), is_first_ahead),
            (self.second.take(), !is_first_ahead),
        ];
        for (waiting, is_stale) in waiting {
            if let Some((stamp, item)) = waiting {
                if !is_stale {
                    self.last = stamp;
                }
                out(item, is_stale);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stamps that are of no use; all come out in the order in which they went in.
    fn stale(stamps: &[i64]) -> Vec<i64> {
        let (mut given, mut stale) = (Vec::new(), Vec::new());
        let out = &mut |stamp: i64, is_stale: bool| {
            given.push(stamp);
            if is_stale {
                stale.push(stamp);
            }
        };
        let mut sequence = Stamps::new();
        for stamp in stamps {
            sequence.push(*stamp, *stamp, out);
        }
        sequence.finish(out);
        assert_eq!(given, stamps);
        stale
    }

    #[test]
    fn one_stamp_far_ahead_costs_one_frame() {
        assert_eq!(stale(&[1, 2, 1000, 3, 4, 5]), [1000]);
        assert_eq!(stale(&[1000, 1, 2, 3]), [1000]);
        assert_eq!(stale(&[1, 900, 2, 3, 800, 4, 5, 700]), [900, 800]);
    }

    #[test]
    fn stamps_that_go_back_or_stay_are_of_no_use() {
        assert_eq!(stale(&[5, 5, 4, 6]), [5, 4]);
        assert_eq!(stale(&[1, 3, 2, 4, 6, 5, 7]), [2, 5]);
        assert_eq!(stale(&[10, 11, 12, 3, 4, 5, 13]), [3, 4, 5]);
        assert_eq!(stale(&[1, 2, 2, 3]), [2]);
        assert_eq!(stale(&[3, 2]), [2]);
    }

    #[test]
    fn a_stamp_before_1970_is_of_no_use() {
        assert_eq!(stale(&[-5, -4, 1, 2, -3, 3]), [-5, -4, -3]);
        assert!(stale(&[0, 1]).is_empty());
    }
}
