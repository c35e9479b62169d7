//! Grains as a LAMMPS text dump, which OVITO opens: one block per frame, one line per grain.
//!
//! Columns: `id` from 1, `type` 1, `x y z` \[m\], `radius` \[m\], `vx vy vz` \[m/s\].
//! Where the structure is analyzed also `d_min` \[m\], since the frame before, `phi`, the local volume fraction, and `contacts`;
//! `nan` where a grain has none.
//! The time step is the number of steps done; the box is the one around the membrane, and nothing is periodic.

use std::fmt::Write;

use super::Frame;

const ANY_TEXT: &str = "a string takes any text";

/// The file of `frames`, whose grains have these `radii` \[m\].
pub(in crate::beam) fn dump(frames: &[Frame], radii: &[f32]) -> Vec<u8> {
    let mut text = String::new();
    for frame in frames {
        head(&mut text, frame).expect(ANY_TEXT);
        for (i, &radius) in radii.iter().enumerate() {
            line(&mut text, frame, i, radius).expect(ANY_TEXT);
        }
    }
    text.into_bytes()
}

fn head(text: &mut String, frame: &Frame) -> std::fmt::Result {
    writeln!(text, "ITEM: TIMESTEP\n{}", frame.step)?;
    writeln!(text, "ITEM: NUMBER OF ATOMS\n{}", frame.positions.len())?;
    writeln!(text, "ITEM: BOX BOUNDS ff ff ff")?;
    let [low, high] = frame.bounds();
    for k in 0..3 {
        writeln!(text, "{:e} {:e}", low[k], high[k])?;
    }
    write!(text, "ITEM: ATOMS id type x y z radius vx vy vz")?;
    if !frame.values.is_empty() {
        write!(text, " d_min phi contacts")?;
    }
    writeln!(text)
}

fn line(text: &mut String, frame: &Frame, i: usize, radius: f32) -> std::fmt::Result {
    let ([x, y, z], [vx, vy, vz]) = (frame.positions[i], frame.velocities[i]);
    write!(
        text,
        "{} 1 {x:e} {y:e} {z:e} {radius:e} {vx:e} {vy:e} {vz:e}",
        i + 1
    )?;
    if let Some(of) = frame.values.get(i) {
        for value in [of.non_affine, of.local_volume_fraction] {
            if value.is_nan() {
                write!(text, " nan")?;
            } else {
                write!(text, " {value:e}")?;
            }
        }
        write!(text, " {}", of.contacts)?;
    }
    writeln!(text)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{frame, values};
    use super::*;

    /// Blocks of a dump by its keywords: time step, box, names of columns, and rows of numbers.
    type Block = (u64, Vec<Vec<f32>>, Vec<String>, Vec<Vec<f32>>);

    /// Reads a dump by the words of LAMMPS' manual, knowing nothing of the writer.
    fn parsed(bytes: &[u8]) -> Vec<Block> {
        let text = std::str::from_utf8(bytes).expect("text");
        let mut lines = text.lines();
        let mut blocks = vec![];
        let numbers = |line: &str| -> Vec<f32> {
            let words = line.split_whitespace();
            words.map(|word| word.parse().expect("a number")).collect()
        };
        while let Some(line) = lines.next() {
            assert_eq!(line, "ITEM: TIMESTEP");
            let step = lines.next().expect("a step").parse().expect("a number");
            assert_eq!(lines.next(), Some("ITEM: NUMBER OF ATOMS"));
            let count: usize = lines.next().expect("a count").parse().expect("a number");
            assert!(
                lines
                    .next()
                    .expect("a box")
                    .starts_with("ITEM: BOX BOUNDS ")
            );
            let sides = lines.by_ref().take(3).map(numbers).collect();
            let columns = lines
                .next()
                .and_then(|line| line.strip_prefix("ITEM: ATOMS "));
            let columns = columns.expect("columns").split(' ').map(str::to_owned);
            let columns: Vec<String> = columns.collect();
            let rows: Vec<_> = lines.by_ref().take(count).map(numbers).collect();
            assert!(rows.len() == count && rows.iter().all(|row| row.len() == columns.len()));
            blocks.push((step, sides, columns, rows));
        }
        blocks
    }

    #[test]
    fn a_dump_is_read_back_to_the_last_bit() {
        let frames = [frame(10, vec![]), frame(20, values())];
        let radii = [2.2e-3, 2.5e-3];
        let blocks = parsed(&dump(&frames, &radii));
        assert_eq!(blocks.len(), 2);
        for (frame, (step, sides, columns, rows)) in frames.iter().zip(&blocks) {
            assert_eq!(*step, frame.step);
            assert_eq!(sides, &[[-1.0, 1.0], [-1.0, 1.0], [-1.0, 4.0]]);
            for (i, row) in rows.iter().enumerate() {
                let [x, y, z] = frame.positions[i];
                let [vx, vy, vz] = frame.velocities[i];
                let number = (i + 1) as f32;
                let expected = [number, 1.0, x, y, z, radii[i], vx, vy, vz];
                assert_eq!(row[..9], expected);
            }
            assert_eq!(columns[..3], ["id", "type", "x"]);
        }
        let (_, _, columns, rows) = &blocks[1];
        assert_eq!(columns[9..], ["d_min", "phi", "contacts"]);
        assert_eq!(rows[0][9..], [1e-5, 0.5, 4.0]);
        assert!(rows[1][9].is_nan());
    }

    #[test]
    fn a_membrane_without_grains_has_blocks_without_rows() {
        let empty = Frame {
            positions: vec![],
            velocities: vec![],
            ..frame(1, vec![])
        };
        let blocks = parsed(&dump(&[empty], &[]));
        assert!(blocks[0].3.is_empty());
    }
}
