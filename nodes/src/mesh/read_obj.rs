//! Wavefront OBJ, parsed by tobj. Faces are checked line by line beforehand, since tobj's errors know no
//! line and its arithmetic trusts indices.

use std::cell::Cell;
use std::io::{BufRead, Read};

use tobj::LoadOptions;

use super::read::MeshError;
use crate::data::Mesh;

/// A mesh of all objects in an OBJ file; materials are ignored.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    check(bytes)?;
    let options =
        LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let line = Cell::new(0);
    let mut reader = CountingLines { rest: bytes, line: &line };
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, |_| Ok(Default::default()))
        .map_err(|error| MeshError::syntax("OBJ", format!("line {}", line.get()), error.to_string()))?;
    let mut mesh = Mesh::default();
    let models: Vec<_> = models.into_iter().filter(|model| !model.mesh.indices.is_empty()).collect();
    let has_uvs = models.iter().all(|m| m.mesh.texcoords.len() / 2 == m.mesh.positions.len() / 3);
    let has_normals = models.iter().all(|m| m.mesh.normals.len() == m.mesh.positions.len());
    let has_colors = models.iter().all(|m| m.mesh.vertex_color.len() == m.mesh.positions.len());
    for model in &models {
        let first = u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX);
        let part = &model.mesh;
        mesh.positions.extend(triples(&part.positions));
        if has_normals {
            mesh.normals.extend(triples(&part.normals));
        }
        if has_uvs {
            mesh.uvs.extend(part.texcoords.chunks_exact(2).map(|uv| [uv[0], 1.0 - uv[1]]));
        }
        if has_colors {
            let byte = |c: f32| (c * 255.0 + 0.5).clamp(0.0, 255.0) as u8;
            mesh.colors.extend(triples(&part.vertex_color).map(|[r, g, b]| [byte(r), byte(g), byte(b), 255]));
        }
        let corner = |i: u32| first.saturating_add(i);
        mesh.triangles
            .extend(part.indices.chunks_exact(3).map(|t| [corner(t[0]), corner(t[1]), corner(t[2])]));
    }
    if !has_uvs && models.iter().any(|m| !m.mesh.texcoords.is_empty()) {
        mesh.notes.push("left out the UVs, since some faces have none".to_owned());
    }
    if let [model] = &models[..] {
        mesh.name.clone_from(&model.name);
    }
    Ok(mesh)
}

fn triples(numbers: &[f32]) -> impl Iterator<Item = [f32; 3]> + '_ {
    numbers.chunks_exact(3).map(|n| [n[0], n[1], n[2]])
}

/// Checks that every face names vertices, texture coordinates and normals that are there.
fn check(bytes: &[u8]) -> Result<(), MeshError> {
    let error =
        |line: usize, problem: String| Err(MeshError::syntax("OBJ", format!("line {}", line + 1), problem));
    let lines = || bytes.split(|&b| b == b'\n').enumerate();
    let mut totals = [0usize; 3];
    let mut faces = 0usize;
    for (number, line) in lines() {
        let Ok(line) = std::str::from_utf8(line) else {
            return error(number, "the text is not UTF-8".to_owned());
        };
        match line.split_whitespace().next() {
            Some("v") => totals[0] += 1,
            Some("vt") => totals[1] += 1,
            Some("vn") => totals[2] += 1,
            Some("f") => faces += 1,
            _ => {}
        }
    }
    if faces == 0 {
        return Err(MeshError::NoFaces(format!(
            ": no line of the OBJ starts with `f` ({} vertices)",
            totals[0]
        )));
    }
    let mut counts = [0usize; 3];
    for (number, line) in lines() {
        let mut words = std::str::from_utf8(line).unwrap_or_default().split_whitespace();
        match words.next() {
            Some("v") => counts[0] += 1,
            Some("vt") => counts[1] += 1,
            Some("vn") => counts[2] += 1,
            Some("f" | "l" | "p") => {
                let mut corners = 0;
                for corner in words {
                    corners += 1;
                    if let Err(problem) = check_corner(corner, counts, totals) {
                        return error(number, problem);
                    }
                }
                if corners == 0 {
                    return error(number, "a face without vertices".to_owned());
                }
            }
            _ => {}
        }
    }
    Ok(())
}

fn check_corner(corner: &str, counts: [usize; 3], totals: [usize; 3]) -> Result<(), String> {
    let parts: Vec<&str> = corner.split('/').collect();
    if parts.len() > 3 || parts[0].is_empty() {
        return Err(format!("`{corner}` is not a face corner such as 1, 1/1, 1//1 or 1/1/1"));
    }
    for (kind, part) in parts.iter().enumerate().filter(|(_, part)| !part.is_empty()) {
        let what = ["vertex", "texture coordinate", "normal"][kind];
        let index: i64 = part.parse().map_err(|_| format!("`{part}` in `{corner}` is not a whole number"))?;
        let resolved = if index < 0 { counts[kind] as i64 + 1 + index.max(-(1 << 40)) } else { index };
        if resolved < 1 || resolved > totals[kind] as i64 {
            return Err(format!("`{corner}` names {what} {index}, but there are {}", totals[kind]));
        }
    }
    Ok(())
}

/// Counts the lines that a reader has taken.
struct CountingLines<'a> {
    rest: &'a [u8],
    line: &'a Cell<usize>,
}

impl Read for CountingLines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.rest.read(buffer)?;
        Ok(n)
    }
}

impl BufRead for CountingLines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        // One line at a time, so that the count is exact.
        let end = self.rest.iter().position(|&b| b == b'\n').map_or(self.rest.len(), |at| at + 1);
        Ok(&self.rest[..end])
    }
    fn consume(&mut self, amount: usize) {
        if amount > 0 {
            self.line.set(self.line.get() + 1);
        }
        self.rest = self.rest.get(amount..).unwrap_or_default();
    }
}
