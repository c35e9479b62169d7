//! The membrane as VTK PolyData in XML (`.vtp`), one file per frame, and the collection of them (`.pvd`), which ParaView opens.
//!
//! Numbers stand as text: points \[m\] in single precision, and the triangles, turned outward; the time \[s\] is the field `TimeValue`.

use std::fmt::Write;

use super::Frame;

const ANY_TEXT: &str = "a string takes any text";

/// The file of the membrane in `frame`.
pub(in crate::beam) fn polydata(frame: &Frame, triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut text = String::new();
    write(&mut text, frame, triangles).expect(ANY_TEXT);
    text.into_bytes()
}

fn write(text: &mut String, frame: &Frame, triangles: &[[u32; 3]]) -> std::fmt::Result {
    let (points, polys) = (frame.vertices.len(), triangles.len());
    writeln!(text, r#"<?xml version="1.0"?>"#)?;
    writeln!(
        text,
        r#"<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian">"#
    )?;
    writeln!(text, "<PolyData>\n<FieldData>")?;
    writeln!(
        text,
        r#"<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">"#
    )?;
    writeln!(text, "{:e}\n</DataArray>\n</FieldData>", frame.time)?;
    writeln!(
        text,
        r#"<Piece NumberOfPoints="{points}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{polys}">"#
    )?;
    writeln!(
        text,
        r#"<Points>
<DataArray type="Float32" NumberOfComponents="3" format="ascii">"#
    )?;
    for [x, y, z] in &frame.vertices {
        writeln!(text, "{x:e} {y:e} {z:e}")?;
    }
    writeln!(
        text,
        r#"</DataArray>
</Points>
<Polys>
<DataArray type="Int32" Name="connectivity" format="ascii">"#
    )?;
    for [a, b, c] in triangles {
        writeln!(text, "{a} {b} {c}")?;
    }
    writeln!(
        text,
        r#"</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">"#
    )?;
    for k in 1..=polys {
        writeln!(text, "{}", 3 * k)?;
    }
    writeln!(
        text,
        "</DataArray>\n</Polys>\n</Piece>\n</PolyData>\n</VTKFile>"
    )
}

/// The name of the file of frame number `k`.
pub(in crate::beam) fn file_name(k: usize) -> String {
    format!("membrane_{k:04}.vtp")
}

/// The collection of the files of all `frames`, which lie beside it.
pub(in crate::beam) fn collection(frames: &[Frame]) -> Vec<u8> {
    let mut text = String::from(
        r#"<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
<Collection>
"#,
    );
    for (k, frame) in frames.iter().enumerate() {
        let (time, file) = (frame.time, file_name(k));
        writeln!(
            text,
            r#"<DataSet timestep="{time:e}" part="0" file="{file}"/>"#
        )
        .expect(ANY_TEXT);
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::super::tests::frame;
    use super::*;

    /// Attributes and text of each element of this name, in order.
    fn elements<'a>(text: &'a str, name: &str) -> Vec<(&'a str, &'a str)> {
        let mut found = vec![];
        for part in text.split(&format!("<{name} ")).skip(1) {
            let (attributes, rest) = part.split_once('>').expect("the end of a tag");
            let body = rest.split_once(&format!("</{name}>"));
            found.push((attributes, body.map_or("", |(body, _)| body)));
        }
        found
    }

    fn attribute<'a>(attributes: &'a str, name: &str) -> Option<&'a str> {
        let (_, rest) = attributes.split_once(&format!("{name}=\""))?;
        rest.split('"').next()
    }

    /// Every tag that is opened is closed, in turn.
    fn is_balanced(text: &str) -> bool {
        let mut open = vec![];
        for tag in text.split('<').skip(1) {
            let tag = tag.split('>').next().unwrap_or("");
            if let Some(name) = tag.strip_prefix('/') {
                if open.pop() != Some(name) {
                    return false;
                }
            } else if !tag.ends_with('/') && !tag.starts_with('?') {
                open.push(tag.split(' ').next().unwrap_or(""));
            }
        }
        open.is_empty()
    }

    fn numbers<T: std::str::FromStr>(text: &str) -> Vec<T> {
        let words = text.split_whitespace();
        words.filter_map(|word| word.parse().ok()).collect()
    }

    #[test]
    fn a_membrane_is_read_back_to_the_last_bit() {
        let frame = frame(1, vec![]);
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let bytes = polydata(&frame, &triangles);
        let text = std::str::from_utf8(&bytes).expect("text");
        assert!(is_balanced(text));
        let piece = elements(text, "Piece")[0].0;
        assert_eq!(attribute(piece, "NumberOfPoints"), Some("4"));
        assert_eq!(attribute(piece, "NumberOfPolys"), Some("4"));
        let arrays = elements(text, "DataArray");
        let names = arrays.iter().map(|(tag, _)| attribute(tag, "Name"));
        let names: Vec<_> = names.collect();
        assert_eq!(
            names,
            [
                Some("TimeValue"),
                None,
                Some("connectivity"),
                Some("offsets")
            ]
        );
        assert_eq!(numbers::<f64>(arrays[0].1), [0.125]);
        assert_eq!(numbers::<f32>(arrays[1].1), frame.vertices.as_flattened());
        assert_eq!(numbers::<u32>(arrays[2].1), triangles.as_flattened());
        assert_eq!(numbers::<u32>(arrays[3].1), [3, 6, 9, 12]);
    }

    #[test]
    fn a_collection_names_the_file_of_each_frame_with_its_time() {
        let bytes = collection(&[frame(1, vec![]), frame(2, vec![])]);
        let text = std::str::from_utf8(&bytes).expect("text");
        assert!(is_balanced(text));
        let sets = elements(text, "DataSet");
        let files: Vec<_> = sets.iter().map(|(tag, _)| attribute(tag, "file")).collect();
        assert_eq!(
            files,
            [Some("membrane_0000.vtp"), Some("membrane_0001.vtp")]
        );
        assert_eq!(attribute(sets[1].0, "timestep"), Some("1.25e-1"));
    }
}
