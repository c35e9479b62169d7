//! Waveforms as a table of u and I, straight from row to row.

use serde::{Deserialize, Serialize};

/// The most rows of a table.
const MAX_ROWS: usize = 2000;

/// I(u) at rising u from 0 to 1, and on the straight line between two rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampled {
    /// u of every row: 0, rising, 1.
    pub u: Vec<f64>,
    /// I of every row, |I| ≤ 1.
    pub shear: Vec<f64>,
}

impl Sampled {
    /// Reads lines of u and I, apart by commas, semicolons or blanks; empty lines, those that begin with `#`, and a heading are passed over.
    ///
    /// # Errors
    /// The line that is no row, or the rule that is broken and where.
    pub fn from_csv(text: &str) -> Result<Self, String> {
        let (mut table, mut lines) = (
            Self {
                u: vec![],
                shear: vec![],
            },
            vec![],
        );
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            if table.u.len() == MAX_ROWS {
                return Err(format!(
                    "line {number}: there may be at most {MAX_ROWS} rows"
                ));
            }
            let cells = line
                .split([',', ';', ' ', '\t'])
                .filter(|cell| !cell.is_empty());
            let cells: Vec<Option<f64>> = cells.map(|cell| cell.parse().ok()).collect();
            match cells[..] {
                [Some(u), Some(shear)] => {
                    table.u.push(u);
                    table.shear.push(shear);
                    lines.push(number);
                }
                [None, None] if table.u.is_empty() => {}
                _ => {
                    let shown: String = line.chars().take(40).collect();
                    return Err(format!(
                        "line {number}: \"{shown}\" is not a pair of numbers, u and I"
                    ));
                }
            }
        }
        table.check(|row| format!("line {}", lines[row]))?;
        Ok(table)
    }

    /// Refuses tables that are not finite, out of range or not on \[0, 1\]; `place` names a row, from 0.
    pub(super) fn check(&self, place: impl Fn(usize) -> String) -> Result<(), String> {
        let (rows, others) = (self.u.len(), self.shear.len());
        if rows != others {
            return Err(format!("{rows} values of u but {others} of shear"));
        }
        if !(2..=MAX_ROWS).contains(&rows) {
            return Err(format!("{rows} rows: there must be 2 … {MAX_ROWS}"));
        }
        let mut before = None;
        for (row, (&u, &shear)) in self.u.iter().zip(&self.shear).enumerate() {
            if !(0.0..=1.0).contains(&u) {
                return Err(format!("{}: u = {u} is not in [0, 1]", place(row)));
            }
            if !(-1.0..=1.0).contains(&shear) {
                return Err(format!("{}: I = {shear} is not in [-1, 1]", place(row)));
            }
            if before.is_some_and(|before| u <= before) {
                return Err(format!(
                    "{}: u = {u} does not rise from the row before",
                    place(row)
                ));
            }
            before = Some(u);
        }
        if self.u[0] > 0.0 {
            return Err(format!("{}: u begins at {}, not at 0", place(0), self.u[0]));
        }
        if self.u[rows - 1] < 1.0 {
            let last = self.u[rows - 1];
            return Err(format!("{}: u ends at {last}, not at 1", place(rows - 1)));
        }
        Ok(())
    }

    /// The row before which `u` lies; the second at least.
    fn after(&self, u: f64) -> usize {
        let row = self.u.partition_point(|&of_row| of_row <= u);
        row.clamp(1, self.u.len() - 1)
    }

    /// I(u) by the straight line; what is outside of \[0, 1\] counts as its end.
    #[must_use]
    pub fn shear(&self, u: f64) -> f64 {
        let k = self.after(u);
        self.between(k, u.clamp(0.0, 1.0))
    }

    fn between(&self, k: usize, u: f64) -> f64 {
        let share = (u - self.u[k - 1]) / (self.u[k] - self.u[k - 1]);
        self.shear[k - 1] + share * (self.shear[k] - self.shear[k - 1])
    }

    /// J(u) = ∫₀ᵘ I(v) dv, exact: a sum of trapezoids.
    #[must_use]
    pub fn integral(&self, u: f64) -> f64 {
        let u = u.clamp(0.0, 1.0);
        let k = self.after(u);
        let mut sum = 0.0;
        for row in 1..k {
            sum += 0.5 * (self.shear[row - 1] + self.shear[row]) * (self.u[row] - self.u[row - 1]);
        }
        sum + 0.5 * (self.shear[k - 1] + self.between(k, u)) * (u - self.u[k - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integral_of_a_tent_is_its_area() {
        let tent = Sampled::from_csv("u,I\n0,0\n0.25,1\n1,-0.5\n").expect("a table");
        // By hand: 1/8 up to u = ¼; then I = 1 − 2 (u − ¼), whose integral is x − x² of x = u − ¼.
        for (u, expected) in [
            (0.0, 0.0),
            (0.125, 0.03125),
            (0.25, 0.125),
            (0.5, 0.3125),
            (1.0, 0.3125),
        ] {
            assert!((tent.integral(u) - expected).abs() < 1e-15, "{u}");
        }
        for (u, expected) in [
            (0.0, 0.0),
            (0.125, 0.5),
            (0.25, 1.0),
            (0.75, 0.0),
            (1.0, -0.5),
        ] {
            assert!((tent.shear(u) - expected).abs() < 1e-15, "{u}");
        }
    }

    #[test]
    fn integral_is_that_of_the_straight_lines_whatever_the_rows() {
        // Midpoint sums over parts that end at every row are exact for straight lines, but for rounding: 1,000 terms.
        let rows = (0..=20).map(|k| (f64::from(k * k) / 400.0, f64::from(k * 7 % 11) / 11.0 - 0.4));
        let (u, shear) = rows.unzip();
        let table = Sampled { u, shear };
        table.check(|row| row.to_string()).expect("a table");
        let mut sum = 0.0;
        for pair in table.u.windows(2) {
            let h = (pair[1] - pair[0]) / 50.0;
            for k in 0..50 {
                sum += h * table.shear(pair[0] + (f64::from(k) + 0.5) * h);
            }
            assert!((sum - table.integral(pair[1])).abs() < 1e-13, "{}", pair[1]);
        }
    }

    #[test]
    fn every_notation_of_a_table_is_read_and_wrong_rows_are_named() {
        let one = Sampled::from_csv("# mine\nu;I\n0;0.5\n\n1;-1\n").expect("a table");
        let other = Sampled::from_csv("0 0.5\n 1\t-1.0\r\n").expect("a table");
        assert_eq!(one, other);
        for (text, told) in [
            ("", "0 rows"),
            ("u,I\n0,0\n", "1 rows"),
            ("0,0\n0.5,nan\n1,0", "line 2: I = NaN"),
            ("0,0\n0.5,1.5\n1,0", "line 2: I = 1.5"),
            ("0,0\n\n0.5,0\n0.5,0\n1,0", "line 4: u = 0.5 does not rise"),
            ("0.1,0\n1,0", "line 1: u begins at 0.1"),
            ("0,0\n0.9,0", "line 2: u ends at 0.9"),
            ("0,0\n2,0", "line 2: u = 2 is not in"),
            ("0,0\nhalf,1\n1,0", "line 2: \"half,1\""),
            ("0,0,0\n1,0,0", "line 1: \"0,0,0\""),
            ("0,inf\n1,0", "line 1: I = inf"),
        ] {
            let error = Sampled::from_csv(text).expect_err(text);
            assert!(error.starts_with(told), "{text:?}: {error}");
        }
    }
}
