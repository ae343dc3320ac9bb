//! Sizes in bytes, as people write and read them.

/// Reads `2G`, `512M`, `64k` or a number of bytes; units are powers of 1024.
///
/// # Errors
/// A message for anything else.
pub fn parse(text: &str) -> Result<u64, String> {
    let wrong = || format!("found `{text}`, expected a size such as 512M, 2G or 1.5GiB");
    let trimmed = text.trim();
    let digits = trimmed.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let shift = match trimmed.get(digits.len()..).unwrap_or_default().to_lowercase().as_str() {
        "" | "b" => 0,
        "k" | "kb" | "kib" => 10,
        "m" | "mb" | "mib" => 20,
        "g" | "gb" | "gib" => 30,
        "t" | "tb" | "tib" => 40,
        _ => return Err(wrong()),
    };
    let number: f64 = digits.trim().parse().map_err(|_| wrong())?;
    let bytes =
        number * f64::from(1u32 << (shift % 30)) * if shift >= 30 { f64::from(1u32 << 30) } else { 1.0 };
    if (1.0..1e18).contains(&bytes) { Ok(bytes as u64) } else { Err(wrong()) }
}

/// A size for people to read: `6.3 MB`.
pub fn human(bytes: u64) -> String {
    let mut number = bytes as f64;
    let mut unit = "bytes";
    for larger in ["kB", "MB", "GB", "TB"] {
        if number < 1000.0 {
            break;
        }
        number /= 1000.0;
        unit = larger;
    }
    if unit == "bytes" { format!("{bytes} bytes") } else { format!("{number:.1} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units_of_1024() {
        for (text, bytes) in [
            ("100", 100),
            ("64k", 65_536),
            ("2G", 2 << 30),
            ("1.5GiB", 3 << 29),
            ("1T", 1 << 40),
            (" 3 MB ", 3 << 20),
        ] {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
        for text in ["", "G", "-1G", "2X", "1e300", "NaN", "0", "two"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_written_with_one_decimal() {
        assert_eq!(human(999), "999 bytes");
        assert_eq!(human(6_291_456), "6.3 MB");
    }
}
