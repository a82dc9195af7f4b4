//! The header of a PLY file: what is in it, and how it is written.

use super::read::Wrong;

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    fn of(name: &str) -> Option<Kind> {
        Some(match name {
            "char" | "int8" => Kind::I8,
            "uchar" | "uint8" => Kind::U8,
            "short" | "int16" => Kind::I16,
            "ushort" | "uint16" => Kind::U16,
            "int" | "int32" => Kind::I32,
            "uint" | "uint32" => Kind::U32,
            // Not in the format's first description, but written for large meshes.
            "int64" | "long" => Kind::I64,
            "uint64" | "ulong" => Kind::U64,
            "float" | "float32" => Kind::F32,
            "double" | "float64" => Kind::F64,
            _ => return None,
        })
    }

    /// Its bytes.
    pub fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }

    /// The value of its bytes, the least significant first.
    pub fn value(self, w: [u8; 8]) -> f64 {
        let half = u16::from_le_bytes([w[0], w[1]]);
        let word = u32::from_le_bytes([w[0], w[1], w[2], w[3]]);
        match self {
            Kind::I8 => f64::from(w[0] as i8),
            Kind::U8 => f64::from(w[0]),
            Kind::I16 => f64::from(half as i16),
            Kind::U16 => f64::from(half),
            Kind::I32 => f64::from(word as i32),
            Kind::U32 => f64::from(word),
            Kind::I64 => i64::from_le_bytes(w) as f64,
            Kind::U64 => u64::from_le_bytes(w) as f64,
            Kind::F32 => f64::from(f32::from_bits(word)),
            Kind::F64 => f64::from_le_bytes(w),
        }
    }
}

/// One value of each entry, or a list of them.
#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
    /// Of a list: the type of the number that says how many values follow.
    pub count: Option<Kind>,
}

/// A kind of entries: vertices, faces.
#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// How many bytes an entry has at least: an empty list is just its count.
    pub fn least_size(&self, encoding: Encoding) -> usize {
        let size = |p: &Property| match encoding {
            // A digit and a blank.
            Encoding::Text => 2,
            _ => p.count.unwrap_or(p.kind).size(),
        };
        self.properties.iter().map(size).sum()
    }
}

/// What the file says of itself.
#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Names that `pse` has written of surfaces.
    pub surfaces: Vec<String>,
    /// Its bytes.
    pub length: usize,
}

impl Header {
    pub fn read(bytes: &[u8]) -> Result<Header, Wrong> {
        let (mut encoding, mut elements, mut surfaces) = (None, Vec::<Element>::new(), Vec::new());
        let mut at = 0;
        // All lines end as the first one does: behind the last one binary data may begin with any byte.
        let first = bytes.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(0);
        let break_at = if bytes[first..].starts_with(b"\r") && !bytes[first..].starts_with(b"\r\n") {
            b'\r'
        } else {
            b'\n'
        };
        for number in 1.. {
            let rest = &bytes[at..];
            let end = rest.iter().position(|&b| b == break_at).ok_or("its header has no end (end_header)")?;
            at += end + 1;
            let line = String::from_utf8_lossy(&rest[..end]);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let wrong = |what: &str| format!("line {number} of its header: {what}");
            let kind = |name: &str| Kind::of(name).ok_or_else(|| wrong(&format!("`{name}` is not a type")));
            match words[..] {
                ["end_header"] => break,
                ["format", format, ..] => {
                    encoding = Some(match format {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => return Err(wrong(&format!("`{format}` is not a format"))),
                    });
                }
                ["comment", "surface", ..] => {
                    let name = line.split_once("surface").map_or("", |(_, name)| name.trim());
                    surfaces.push(name.to_string());
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| wrong(&format!("`{count}` is not a count")))?;
                    elements.push(Element { name: name.into(), count, properties: Vec::new() });
                }
                ["property", ref words @ ..] => {
                    let element =
                        elements.last_mut().ok_or_else(|| wrong("a property without an element"))?;
                    element.properties.push(match *words {
                        ["list", count, of, name] => {
                            Property { name: name.into(), kind: kind(of)?, count: Some(kind(count)?) }
                        }
                        [of, name] => Property { name: name.into(), kind: kind(of)?, count: None },
                        _ => return Err(wrong("a property has a type and a name")),
                    });
                }
                ["element", ..] => return Err(wrong("an element has a name and a count")),
                // `ply`, comments, what programs note of themselves.
                _ => {}
            }
        }
        let encoding = encoding.ok_or("its header has no format")?;
        Ok(Header { encoding, elements, surfaces, length: at })
    }
}
