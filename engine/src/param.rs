//! Parameter values: reading, writing, and checking them against what a parameter takes.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, SeqAccess, Visitor};

use crate::spec::{ParamKind, ParamValue};

/// A value on the command line that starts like RON but is not.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "found `{text}`, expected a value such as 128, 0.2, true, (1, 2, 3), \"text\" or a bare word: {reason}"
)]
pub struct ValueError {
    /// What was given.
    pub text: String,
    /// What RON says of it.
    pub reason: String,
}

/// Reads a value from the command line: RON, or else a text. Bare words and paths need no quotes.
///
/// ```
/// use breccia_engine::{ParamValue, parse_value};
/// assert_eq!(parse_value("128").unwrap(), ParamValue::Int(128));
/// assert_eq!(parse_value("cyclic").unwrap(), ParamValue::Text("cyclic".into()));
/// ```
///
/// # Errors
/// If the text starts with a bracket or a quote and is no RON value.
pub fn parse_value(text: &str) -> Result<ParamValue, ValueError> {
    let trimmed = text.trim();
    let bracketed = trimmed.starts_with(['(', '[', '"']);
    let numeric = trimmed.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
    let literal = matches!(trimmed, "true" | "false" | "inf" | "NaN");
    if !(bracketed || numeric || literal) {
        return Ok(ParamValue::Text(text.to_owned()));
    }
    match ron::from_str(trimmed) {
        Ok(value) => Ok(value),
        Err(error) if bracketed => {
            Err(ValueError { text: trimmed.to_owned(), reason: error.code.to_string() })
        }
        Err(_) => Ok(ParamValue::Text(text.to_owned())),
    }
}

impl ParamValue {
    /// The value as it stands in a RON tree, or `None` for what no parameter can be.
    pub fn from_ron(value: &ron::Value) -> Option<Self> {
        value.clone().into_rust().ok()
    }

    /// What kind of value it is, for messages.
    pub fn kind_name(&self) -> &'static str {
        match self {
            Self::Bool(_) => "a truth value",
            Self::Int(_) => "a whole number",
            Self::Float(_) => "a real number",
            Self::Text(_) => "a text",
            Self::List(_) => "a list",
        }
    }
}

impl fmt::Display for ParamValue {
    /// Writes the value as RON.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(b) => write!(f, "{b}"),
            Self::Int(i) => write!(f, "{i}"),
            Self::Float(x) => f.write_str(&float_text(*x)),
            Self::Text(s) => f.write_str(&quoted(s)),
            Self::List(items) => {
                // A tuple of one looks like a bracketed number, hence square brackets for short lists.
                let (open, close) = if items.len() < 2 { ('[', ']') } else { ('(', ')') };
                write!(f, "{open}")?;
                for (i, item) in items.iter().enumerate() {
                    if i > 0 {
                        f.write_str(", ")?;
                    }
                    write!(f, "{item}")?;
                }
                write!(f, "{close}")
            }
        }
    }
}

/// A float as RON that reads back to the same bits.
pub(crate) fn float_text(x: f64) -> String {
    let sign = if x.is_nan() && x.is_sign_negative() { "-" } else { "" };
    format!("{sign}{x:?}")
}

/// A text as a RON string. Control characters are escaped one by one, line breaks too.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => out.push_str(&format!("\\u{{{:x}}}", c as u32)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

impl<'de> Deserialize<'de> for ParamValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ParamVisitor)
    }
}

struct ParamVisitor;

impl<'de> Visitor<'de> for ParamVisitor {
    type Value = ParamValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("true, false, a number, a quoted text or a list of these")
    }

    fn visit_bool<E: de::Error>(self, v: bool) -> Result<ParamValue, E> {
        Ok(ParamValue::Bool(v))
    }

    fn visit_i64<E: de::Error>(self, v: i64) -> Result<ParamValue, E> {
        Ok(ParamValue::Int(v))
    }

    fn visit_u64<E: de::Error>(self, v: u64) -> Result<ParamValue, E> {
        i64::try_from(v)
            .map(ParamValue::Int)
            .map_err(|_| E::custom(format!("found {v}, whole numbers go up to {}", i64::MAX)))
    }

    fn visit_f64<E: de::Error>(self, v: f64) -> Result<ParamValue, E> {
        Ok(ParamValue::Float(v))
    }

    fn visit_char<E: de::Error>(self, v: char) -> Result<ParamValue, E> {
        Ok(ParamValue::Text(v.to_string()))
    }

    fn visit_str<E: de::Error>(self, v: &str) -> Result<ParamValue, E> {
        Ok(ParamValue::Text(v.to_owned()))
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<ParamValue, D::Error> {
        deserializer.deserialize_any(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<ParamValue, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = seq.next_element()? {
            items.push(item);
        }
        Ok(ParamValue::List(items))
    }
}

/// What a value should have been.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mismatch {
    pub found: String,
    pub expected: String,
    pub suggestion: Option<String>,
}

impl ParamKind {
    /// What the parameter takes, in words: `a whole number from 1 to 4096`.
    pub fn describe(&self) -> String {
        match self {
            Self::Bool => "true or false".into(),
            Self::Int { min, max } => format!("a whole number {}", int_range(*min, *max)),
            Self::Float { min, max, .. } => format!("a number {}", float_range(*min, *max)),
            Self::Choice(choices) => {
                let names: Vec<_> = choices.iter().map(|c| format!("\"{}\"", c.0)).collect();
                format!("one of {}", names.join(", "))
            }
            Self::Text => "a text".into(),
            Self::File { extensions: [] } => "the path of a file".into(),
            Self::File { extensions } => format!("the path of a file ({})", extensions.join(", ")),
            Self::Ints { min_len, max_len, min, max } => {
                format!("{} whole numbers, each {}", lengths(*min_len, *max_len), int_range(*min, *max))
            }
            Self::Floats { min_len, max_len, min, max } => {
                format!("{} numbers, each {}", lengths(*min_len, *max_len), float_range(*min, *max))
            }
        }
    }

    /// The canonical form of a value: whole numbers become real ones where the parameter is real.
    pub(crate) fn check(&self, value: &ParamValue) -> Result<ParamValue, Mismatch> {
        // One number will do for a list that may be so short.
        let listed = match (self, value) {
            (Self::Ints { .. } | Self::Floats { .. }, ParamValue::Int(_) | ParamValue::Float(_)) => {
                ParamValue::List(vec![value.clone()])
            }
            _ => value.clone(),
        };
        let ok = match (self, &listed) {
            (Self::Bool, ParamValue::Bool(_)) | (Self::Text | Self::File { .. }, ParamValue::Text(_)) => {
                Some(value.clone())
            }
            (Self::Int { min, max }, v) => whole(v, *min, *max),
            (Self::Float { min, max, .. }, v) => real(v, *min, *max),
            (Self::Choice(choices), ParamValue::Text(text)) => {
                choices.iter().any(|c| c.0 == text).then(|| value.clone())
            }
            (Self::Ints { min_len, max_len, min, max }, ParamValue::List(items))
                if (*min_len..=*max_len).contains(&items.len()) =>
            {
                items.iter().map(|v| whole(v, *min, *max)).collect::<Option<_>>().map(ParamValue::List)
            }
            (Self::Floats { min_len, max_len, min, max }, ParamValue::List(items))
                if (*min_len..=*max_len).contains(&items.len()) =>
            {
                items.iter().map(|v| real(v, *min, *max)).collect::<Option<_>>().map(ParamValue::List)
            }
            _ => None,
        };
        ok.ok_or_else(|| Mismatch {
            found: value.to_string(),
            expected: self.describe(),
            suggestion: match (self, value) {
                (Self::Choice(choices), ParamValue::Text(text)) => {
                    crate::suggest::closest(text, choices.iter().map(|c| c.0))
                }
                _ => None,
            },
        })
    }
}

fn whole(value: &ParamValue, min: i64, max: i64) -> Option<ParamValue> {
    match value {
        ParamValue::Int(i) if (min..=max).contains(i) => Some(value.clone()),
        _ => None,
    }
}

fn real(value: &ParamValue, min: f64, max: f64) -> Option<ParamValue> {
    let x = match value {
        ParamValue::Int(i) => *i as f64,
        ParamValue::Float(x) => *x,
        _ => return None,
    };
    // Adding zero turns -0 into +0, so that equal numbers have equal keys.
    (x >= min && x <= max).then_some(ParamValue::Float(x + 0.0))
}

fn int_range(min: i64, max: i64) -> String {
    match (min == i64::MIN, max == i64::MAX) {
        (true, true) => "of any size".into(),
        (true, false) => format!("up to {max}"),
        (false, true) => format!("from {min}"),
        (false, false) => format!("from {min} to {max}"),
    }
}

fn float_range(min: f64, max: f64) -> String {
    match (min.is_finite() && min > f64::MIN, max.is_finite() && max < f64::MAX) {
        (false, false) => "of any size".into(),
        (false, true) => format!("up to {max}"),
        (true, false) => format!("from {min}"),
        (true, true) => format!("from {min} to {max}"),
    }
}

fn lengths(min: usize, max: usize) -> String {
    if min == max { min.to_string() } else { format!("{min} to {max}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(items: impl IntoIterator<Item = i64>) -> ParamValue {
        ParamValue::List(items.into_iter().map(ParamValue::Int).collect())
    }

    #[test]
    fn values_are_ron_or_text() {
        let text = |s: &str| ParamValue::Text(s.into());
        for (input, expected) in [
            ("128", ParamValue::Int(128)),
            ("-3", ParamValue::Int(-3)),
            ("0.2", ParamValue::Float(0.2)),
            ("-1e-3", ParamValue::Float(-0.001)),
            ("1.0", ParamValue::Float(1.0)),
            ("true", ParamValue::Bool(true)),
            ("(17,17,17)", list([17, 17, 17])),
            ("[1, 2]", list([1, 2])),
            ("(5)", list([5])),
            ("[]", list([])),
            ("\"a b\"", text("a b")),
            ("cyclic", text("cyclic")),
            ("photo.png", text("photo.png")),
            ("./photo.png", text("./photo.png")),
            ("3d.png", text("3d.png")),
            ("builtin:cobbles.png", text("builtin:cobbles.png")),
            ("None", text("None")),
            ("", text("")),
        ] {
            assert_eq!(parse_value(input), Ok(expected), "{input}");
        }
        assert!(parse_value("(1, 2").is_err());
        assert!(parse_value("\"open").is_err());
    }

    #[test]
    fn written_values_read_back() {
        for value in [
            ParamValue::Float(1.0),
            ParamValue::Float(1e300),
            ParamValue::Float(f64::from(0.1f32)),
            ParamValue::Int(i64::MIN),
            ParamValue::Text("quote \" back \\ line\n tab\t bell\u{7} 🪨".into()),
            list([]),
            list([1]),
            list([1, -2, 3]),
        ] {
            assert_eq!(ron::from_str::<ParamValue>(&value.to_string()), Ok(value.clone()), "{value}");
        }
    }

    #[test]
    fn whole_numbers_become_real_where_asked() {
        let kind = ParamKind::Float { min: 0.0, max: 2.0, step: 0.1 };
        assert_eq!(kind.check(&ParamValue::Int(1)), Ok(ParamValue::Float(1.0)));
        assert!(kind.check(&ParamValue::Float(f64::NAN)).is_err());
        assert!(kind.check(&ParamValue::Float(2.5)).is_err());
        let ParamValue::Float(zero) = kind.check(&ParamValue::Float(-0.0)).unwrap() else { panic!() };
        assert!(zero.is_sign_positive());
    }

    #[test]
    fn one_number_is_a_list_of_one() {
        let kind = |min_len| ParamKind::Ints { min_len, max_len: 3, min: 1, max: 99 };
        assert_eq!(kind(1).check(&ParamValue::Int(5)), Ok(list([5])));
        assert_eq!(kind(3).check(&ParamValue::Int(5)).unwrap_err().found, "5");
    }

    #[test]
    fn a_misspelt_choice_gets_a_suggestion() {
        let kind = ParamKind::Choice(&[("cyclic", ""), ("mirror", "")]);
        let error = kind.check(&ParamValue::Text("ciclic".into())).unwrap_err();
        assert_eq!(error.suggestion.as_deref(), Some("cyclic"));
        assert_eq!(error.expected, "one of \"cyclic\", \"mirror\"");
    }
}
