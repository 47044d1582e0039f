//! Other formats than OBJ, by their content, so that a message can name them.

/// Bytes at the begin of a file in which a text format shows what it is.
const HEAD: usize = 4096;

/// Bytes of a binary STL file before its triangles: a comment and their count.
const STL_HEADER: usize = 84;
/// Bytes of a triangle of a binary STL file.
const STL_TRIANGLE: usize = 50;

/// Formats of which the file begins with these bytes.
const MAGIC: [(&[u8], &str); 22] = [
    (b"ply\n", "PLY"),
    (b"ply\r", "PLY"),
    (b"glTF", "binary glTF (GLB)"),
    (b"Kaydara FBX Binary", "FBX"),
    (b"; FBX", "FBX"),
    (b"BLENDER", "Blender's"),
    (b"OFF\n", "OFF"),
    (b"OFF\r", "OFF"),
    (b"COFF", "OFF"),
    (b"#VRML", "VRML"),
    (b"#X3D", "X3D"),
    (b"#usda", "USD"),
    (b"PXR-USDC", "USD"),
    (b"PK\x03\x04", "ZIP"),
    (b"\x1f\x8b", "gzip"),
    (b"\xfd7zXZ", "xz"),
    (b"BZh", "bzip2"),
    (b"\x28\xb5\x2f\xfd", "Zstandard"),
    (b"\x89PNG", "PNG"),
    (b"\xff\xd8\xff", "JPEG"),
    (b"%PDF", "PDF"),
    (b"version https://git-lfs", "Git LFS pointer"),
];

/// What is wrong with a file of another format; none where it may be an OBJ file.
pub(crate) fn refusal(bytes: &[u8]) -> Option<String> {
    let format = recognise(bytes)?;
    let right = if format == "MTL" { "name the OBJ file that uses it" } else { "save the scene as OBJ" };
    Some(format!("is no OBJ file: it is in {format} format; {right}"))
}

/// The name of the format that the content is in, if it is none that could be OBJ.
fn recognise(bytes: &[u8]) -> Option<&'static str> {
    let named = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, name)| *name);
    named.or_else(|| is_binary_stl(bytes).then_some("STL")).or_else(|| recognise_text(bytes))
}

/// Whether there are as many bytes as the count of triangles says.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(STL_HEADER - 4..STL_HEADER).and_then(|count| count.try_into().ok());
    let triangles = count.map(u32::from_le_bytes).filter(|&count| count > 0);
    let length = triangles.and_then(|count| (count as usize).checked_mul(STL_TRIANGLE));
    length.and_then(|length| length.checked_add(STL_HEADER)) == Some(bytes.len())
}

/// Formats of text whose first word an OBJ file could have as well: a second one decides.
fn recognise_text(bytes: &[u8]) -> Option<&'static str> {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]).to_ascii_lowercase();
    let head = head.trim_start_matches(|c: char| c.is_whitespace() || c == '\u{feff}');
    let lines = || head.split(['\n', '\r']).map(str::trim_start);
    if head.starts_with("solid") && lines().any(|line| line.starts_with("facet normal")) {
        return Some("STL");
    }
    if head.starts_with('{') && head.contains('"') {
        return Some(if head.contains("\"asset\"") { "glTF" } else { "JSON" });
    }
    if head.starts_with('<') {
        let formats =
            [("<collada", "COLLADA"), ("<x3d", "X3D"), ("<html", "HTML"), ("<!doctype html", "HTML")];
        return Some(formats.iter().find(|(tag, _)| head.contains(tag)).map_or("XML", |(_, name)| name));
    }
    let begins = |keyword: &str| lines().any(|line| line.split_whitespace().next() == Some(keyword));
    if begins("newmtl") && !["v", "f", "usemtl"].into_iter().any(begins) && bytes.len() <= HEAD {
        return Some("MTL");
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_their_content() {
        let mut stl = b"solid with a header like text".to_vec();
        stl.resize(STL_HEADER - 4, 0);
        stl.extend(2u32.to_le_bytes());
        stl.resize(STL_HEADER + 2 * STL_TRIANGLE, 7);
        let files: [(&[u8], &str); 11] = [
            (b"ply\nformat ascii 1.0\n", "PLY"),
            (&stl, "STL"),
            (b"solid cube\n  facet normal 0 0 1\n    outer loop\n", "STL"),
            (b"glTF\x02\0\0\0", "binary glTF (GLB)"),
            (b"\xef\xbb\xbf {\n \"asset\": {\"version\": \"2.0\"}}", "glTF"),
            (b"{\"a\": 1}", "JSON"),
            (b"<?xml version=\"1.0\"?>\n<COLLADA>", "COLLADA"),
            (b"<!DOCTYPE html><html>", "HTML"),
            (b"OFF\n8 6 0\n", "OFF"),
            (b"# by hand\nnewmtl a\nKd 1 1 1\n", "MTL"),
            (b"version https://git-lfs.github.com/spec/v1\n", "Git LFS pointer"),
        ];
        for (content, name) in files {
            assert_eq!(recognise(content), Some(name));
        }
        for content in
            [&b""[..], b"# ply\nv 0 0 0\n", b"solid\nv 0 0 0\nf 1 1 1\n", b"newmtl\nv 0 0 0\nf 1 1 1\n"]
        {
            assert_eq!(recognise(content), None);
        }
    }
}
