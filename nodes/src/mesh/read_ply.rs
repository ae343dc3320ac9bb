//! PLY: ascii, and binary of both byte orders.

use super::read::MeshError;
use crate::data::Mesh;

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

struct Property {
    name: String,
    /// The type of a list's length, if it is a list.
    length: Option<Scalar>,
    ty: Scalar,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

fn error(place: impl Into<String>, problem: impl Into<String>) -> MeshError {
    MeshError::syntax("PLY", place, problem)
}

/// A mesh of the elements `vertex` and `face`; others are skipped.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let (format, elements, body) = header(bytes)?;
    let mut mesh = Mesh::default();
    let mut values = Values { format, rest: body };
    for element in &elements {
        // Before anything is allocated: each value takes a byte at least, in ascii two with its separator.
        let least: usize = element.properties.iter().map(|p| p.length.unwrap_or(p.ty).size()).sum();
        let least = if format == Format::Ascii { element.properties.len() * 2 } else { least };
        let available = values.rest.len() + usize::from(format == Format::Ascii);
        if element.count.checked_mul(least).is_none_or(|needed| needed > available) {
            let problem =
                format!("{} rows cannot fit into the {available} bytes that are left", element.count);
            return Err(error(format!("element `{}`", element.name), problem));
        }
        if element.properties.is_empty() {
            continue;
        }
        for row in 0..element.count {
            let place = |problem: String| error(format!("element `{}`, row {row}", element.name), problem);
            match element.name.as_str() {
                "vertex" => vertex(&mut mesh, element, &mut values).map_err(place)?,
                "face" => face(&mut mesh, element, &mut values).map_err(place)?,
                _ => skip(element, &mut values).map_err(place)?,
            }
        }
    }
    Ok(mesh)
}

/// The format, the elements, and what follows the header.
fn header(bytes: &[u8]) -> Result<(Format, Vec<Element>, &[u8]), MeshError> {
    let mut rest = bytes;
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    for number in 1.. {
        let place = || format!("header line {number}");
        let end =
            rest.iter().position(|&b| b == b'\n').ok_or_else(|| error(place(), "the header has no end"))?;
        let line = std::str::from_utf8(&rest[..end]).map_err(|_| error(place(), "the header is not text"))?;
        rest = &rest[end + 1..];
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(error(place(), "a PLY file starts with `ply`")),
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, "1.0"] => {
                format = Some(match name {
                    "ascii" => Format::Ascii,
                    "binary_little_endian" => Format::Little,
                    "binary_big_endian" => Format::Big,
                    _ => return Err(error(place(), format!("unknown format `{name}`"))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| error(place(), format!("`{count}` is not a count")))?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref ty @ .., name] => {
                let parse = |name: &str| {
                    Scalar::parse(name).ok_or_else(|| error(place(), format!("unknown type `{name}`")))
                };
                let (length, ty) = match ty {
                    ["list", length, ty] => (Some(parse(length)?), parse(ty)?),
                    [ty] => (None, parse(ty)?),
                    _ => return Err(error(place(), format!("cannot read `{line}`"))),
                };
                let element =
                    elements.last_mut().ok_or_else(|| error(place(), "a property before any element"))?;
                element.properties.push(Property { name: name.to_owned(), length, ty });
            }
            ["end_header"] => {
                let format = format.ok_or_else(|| error(place(), "no line gives the format"))?;
                return Ok((format, elements, rest));
            }
            _ => return Err(error(place(), format!("cannot read `{line}`"))),
        }
    }
    Err(error("header", "the header has no end"))
}

/// The values of the body, one after the other.
struct Values<'a> {
    format: Format,
    rest: &'a [u8],
}

impl Values<'_> {
    fn next(&mut self, ty: Scalar) -> Result<f64, String> {
        if self.format == Format::Ascii {
            let text = self.rest.trim_ascii_start();
            let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
            let (word, rest) = text.split_at(end);
            self.rest = rest;
            let word = String::from_utf8_lossy(word);
            if word.is_empty() {
                return Err("the file ends too early".to_owned());
            }
            return word.parse().map_err(|_| format!("`{word}` is not a number"));
        }
        let (bytes, rest) = self.rest.split_at_checked(ty.size()).ok_or("the file ends too early")?;
        self.rest = rest;
        let mut le = [0u8; 8];
        for (i, &byte) in bytes.iter().enumerate() {
            let at = if self.format == Format::Big { ty.size() - 1 - i } else { i };
            le[at] = byte;
        }
        let [a, b, c, d, ..] = le;
        Ok(match ty {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(le),
        })
    }

    /// The length of a list, which cannot be longer than what is left.
    fn length(&mut self, ty: Scalar) -> Result<usize, String> {
        let length = self.next(ty)?;
        if length < 0.0 || length.fract() != 0.0 || length > self.rest.len() as f64 {
            return Err(format!("a list of {length} values, {} bytes are left", self.rest.len()));
        }
        Ok(length as usize)
    }
}

fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), String> {
    for property in &element.properties {
        let count = property.length.map_or(Ok(1), |ty| values.length(ty))?;
        for _ in 0..count {
            values.next(property.ty)?;
        }
    }
    Ok(())
}

fn vertex(mesh: &mut Mesh, element: &Element, values: &mut Values<'_>) -> Result<(), String> {
    let mut position = [None; 3];
    let mut normal = [None; 3];
    let mut uv = [None; 2];
    let mut color = [None; 4];
    for property in &element.properties {
        if let Some(ty) = property.length {
            for _ in 0..values.length(ty)? {
                values.next(property.ty)?;
            }
            continue;
        }
        let value = values.next(property.ty)?;
        // Colours are bytes, or fractions where they are floats.
        let full = match property.ty {
            Scalar::F32 | Scalar::F64 => 255.0,
            Scalar::U16 => 1.0 / 257.0,
            _ => 1.0,
        };
        let byte = Some((value * full + 0.5).clamp(0.0, 255.0) as u8);
        let number = Some(value as f32);
        match property.name.as_str() {
            "x" => position[0] = number,
            "y" => position[1] = number,
            "z" => position[2] = number,
            "nx" => normal[0] = number,
            "ny" => normal[1] = number,
            "nz" => normal[2] = number,
            "s" | "u" | "texture_u" => uv[0] = number,
            // The origin is at the bottom left, as in OBJ.
            "t" | "v" | "texture_v" => uv[1] = Some((1.0 - value) as f32),
            "red" | "r" | "diffuse_red" => color[0] = byte,
            "green" | "g" | "diffuse_green" => color[1] = byte,
            "blue" | "b" | "diffuse_blue" => color[2] = byte,
            "alpha" | "a" => color[3] = byte,
            _ => {}
        }
    }
    let [Some(x), Some(y), Some(z)] = position else {
        return Err("the vertex has no x, y and z".to_owned());
    };
    mesh.positions.push([x, y, z]);
    if let [Some(x), Some(y), Some(z)] = normal {
        mesh.normals.push([x, y, z]);
    }
    if let [Some(u), Some(v)] = uv {
        mesh.uvs.push([u, v]);
    }
    if let [Some(r), Some(g), Some(b), a] = color {
        mesh.colors.push([r, g, b, a.unwrap_or(255)]);
    }
    Ok(())
}

fn face(mesh: &mut Mesh, element: &Element, values: &mut Values<'_>) -> Result<(), String> {
    for property in &element.properties {
        let Some(ty) = property.length else {
            values.next(property.ty)?;
            continue;
        };
        let count = values.length(ty)?;
        let is_polygon = matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
        let mut hub_and_last = [None; 2];
        for _ in 0..count {
            let value = values.next(property.ty)?;
            if !is_polygon {
                continue;
            }
            if value < 0.0 || value.fract() != 0.0 || value > f64::from(u32::MAX) {
                return Err(format!("{value} is not the number of a vertex"));
            }
            let corner = value as u32;
            match hub_and_last {
                [Some(hub), Some(last)] => {
                    mesh.triangles.push([hub, last, corner]);
                    hub_and_last[1] = Some(corner);
                }
                [Some(_), None] => hub_and_last[1] = Some(corner),
                _ => hub_and_last[0] = Some(corner),
            }
        }
    }
    Ok(())
}
