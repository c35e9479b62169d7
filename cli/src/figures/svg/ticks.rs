//! Axes: which range they show, where their marks stand, and where a value lies.

/// A range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Range {
    /// All of `values` with a little room; from 0 on where that is not far away.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        if low > high {
            return Self {
                low: 0.0,
                high: 1.0,
            };
        }
        let width = if high > low {
            high - low
        } else {
            high.abs().max(1.0)
        };
        let room = 0.05 * width;
        let low = if (0.0..0.6 * high).contains(&low) {
            0.0
        } else {
            low - room
        };
        Self {
            low,
            high: high + room,
        }
    }

    /// All of `values`, which are powers of ten, with a little room.
    pub(super) fn around_powers(values: impl Iterator<Item = f64>) -> Self {
        let Self { low, high } = Self::around_all(values.filter(|value| value.is_finite()));
        let room = 0.08 * (high - low);
        Self {
            low: low - room,
            high: high + room,
        }
    }

    /// All of `values`, and no more.
    pub(super) fn around_all(values: impl Iterator<Item = f64>) -> Self {
        let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
        match ends {
            [low, high] if low < high => Self { low, high },
            [low, high] if low.total_cmp(&high).is_eq() => Self {
                low: low - 0.5,
                high: high + 0.5,
            },
            _ => Self {
                low: 0.0,
                high: 1.0,
            },
        }
    }

    /// Where `value` lies, from 0 to 1 within the range.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Marks at multiples of 1, 2 or 5 times a power of ten, about `count` of them.
    pub(super) fn ticks(&self, count: f64) -> Vec<f64> {
        let rough = (self.high - self.low) / count;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * power)
            .find(|step| *step >= rough * (1.0 - 1e-9))
            .unwrap_or(10.0 * power);
        let [first, last] = [(self.low / step).ceil(), (self.high / step).floor()];
        let marks = (0..100).map(|k| first + f64::from(k));
        marks
            .take_while(|mark| *mark <= last)
            .map(|mark| mark * step + 0.0)
            .collect()
    }
}

/// Powers of ten within the range of powers, and, where those are few, round multiples of them.
pub(super) fn powers(range: Range) -> Vec<f64> {
    let factors: &[f64] = match range.high - range.low {
        ..0.5 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
        0.5..2.5 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let decades = range.low.floor() as i32..=range.high.ceil() as i32;
    let marks = decades.flat_map(|power| factors.iter().map(move |f| f * 10f64.powi(power)));
    marks
        .filter(|mark| (range.low..=range.high).contains(&mark.log10()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_ten_are_marked_and_parts_of_them_where_there_is_room() {
        let range = |low, high| Range { low, high };
        assert_eq!(powers(range(-0.1, 1.4)), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(powers(range(0.0, 3.0)), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(powers(range(0.05, 0.31)), [1.2, 1.5, 2.0]);
    }

    #[test]
    fn marks_are_round_and_within_the_range() {
        let ticks = |low, high| Range { low, high }.ticks(5.0);
        assert_eq!(ticks(0.0, 105.0), [0.0, 50.0, 100.0]);
        assert_eq!(ticks(-1.0, 1.0), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(ticks(5.3, 7.9), [6.0, 7.0]);
    }

    #[test]
    fn range_begins_at_zero_where_that_is_near() {
        let range = |values: &[f64]| Range::around(values.iter().copied());
        assert!(range(&[1.0, 100.0]).low.abs() < 1e-12);
        assert!(range(&[95.0, 100.0]).low > 90.0);
        assert_eq!(
            range(&[]),
            Range {
                low: 0.0,
                high: 1.0
            }
        );
        let one = range(&[3.0]);
        assert!(one.low < 3.0 && 3.0 < one.high);
    }
}
