//! Reads TOML values while keeping their place in the file, so that every refusal can name it.

use crate::{FrameSpecError, FrameSpecFault};
use std::ops::{Range, RangeInclusive};
use toml::de::{DeTable, DeValue};

/// A frame file is a page of text; anything longer is a mistake or an attack.
const MAX_TEXT_LEN: usize = 64 * 1024;
/// Characters of a refused value that an error repeats.
const MAX_QUOTE: usize = 40;

pub(crate) type Result<T> = std::result::Result<T, FrameSpecError>;

/// One table of the file.
#[derive(Debug, Clone)]
pub(crate) struct Table<'a> {
    text: &'a str,
    path: String,
    span: Range<usize>,
    entries: &'a DeTable<'a>,
}

/// One value of the file.
#[derive(Debug, Clone)]
pub(crate) struct Value<'a> {
    text: &'a str,
    path: String,
    span: Range<usize>,
    value: &'a DeValue<'a>,
}

/// Parses `text` and hands its root table to `read`.
pub(crate) fn with_root<T>(text: &str, read: impl FnOnce(&Table<'_>) -> Result<T>) -> Result<T> {
    if text.len() > MAX_TEXT_LEN {
        let fault = FrameSpecFault::TooLong { found: text.len(), limit: MAX_TEXT_LEN };
        return Err(error_at(text, 0..0, "file", fault));
    }
    let root = DeTable::parse(text).map_err(|error| {
        let fault = FrameSpecFault::Syntax { message: error.message().to_owned() };
        error_at(text, error.span().unwrap_or(0..0), "file", fault)
    })?;
    read(&Table { text, path: String::new(), span: root.span(), entries: root.get_ref() })
}

impl<'a> Table<'a> {
    /// Refuses every key outside `known`.
    pub(crate) fn only(&self, known: &[&str]) -> Result<()> {
        for (key, _) in self.entries {
            if !known.contains(&key.get_ref().as_ref()) {
                let fault = FrameSpecFault::UnknownKey { known: known.join(", ") };
                let path = self.path_of(&quote(key.get_ref()));
                return Err(error_at(self.text, key.span(), &path, fault));
            }
        }
        Ok(())
    }

    pub(crate) fn optional(&self, key: &str) -> Option<Value<'a>> {
        let (_, value) = self.entries.iter().find(|(found, _)| found.get_ref() == key)?;
        let path = self.path_of(key);
        Some(Value { text: self.text, path, span: value.span(), value: value.get_ref() })
    }

    pub(crate) fn required(&self, key: &str) -> Result<Value<'a>> {
        self.optional(key).ok_or_else(|| {
            error_at(self.text, self.span.clone(), &self.path_of(key), FrameSpecFault::Missing)
        })
    }

    /// The tables of an array of tables; none when the key is absent.
    pub(crate) fn tables(&self, key: &str, most: usize) -> Result<Vec<Table<'a>>> {
        let Some(value) = self.optional(key) else { return Ok(Vec::new()) };
        let items = value.array()?;
        if items.len() > most {
            return Err(value.out_of_range(format!("at most {most} of them")));
        }
        items.iter().map(Value::table).collect()
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }
}

impl<'a> Value<'a> {
    pub(crate) fn refuse(&self, fault: FrameSpecFault) -> FrameSpecError {
        error_at(self.text, self.span.clone(), &self.path, fault)
    }

    pub(crate) fn out_of_range(&self, expected: impl Into<String>) -> FrameSpecError {
        self.refuse(FrameSpecFault::OutOfRange { expected: expected.into() })
    }

    fn wrong_type(&self, expected: &'static str) -> FrameSpecError {
        self.refuse(FrameSpecFault::WrongType { found: self.value.type_str(), expected })
    }

    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    pub(crate) fn table(&self) -> Result<Table<'a>> {
        let entries = self.value.as_table().ok_or_else(|| self.wrong_type("a table"))?;
        Ok(Table { text: self.text, path: self.path.clone(), span: self.span.clone(), entries })
    }

    pub(crate) fn array(&self) -> Result<Vec<Self>> {
        let items = self.value.as_array().ok_or_else(|| self.wrong_type("an array"))?;
        let place = |(k, item): (usize, &'a toml::Spanned<DeValue<'a>>)| Self {
            text: self.text,
            path: format!("{}[{k}]", self.path),
            span: item.span(),
            value: item.get_ref(),
        };
        Ok(items.iter().enumerate().map(place).collect())
    }

    /// An array of exactly two.
    pub(crate) fn pair(&self) -> Result<[Self; 2]> {
        self.array()?.try_into().map_err(|_| self.out_of_range("two numbers, [first, last]"))
    }

    pub(crate) fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a \"string\""))
    }

    pub(crate) fn boolean(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    /// A finite number; an integer counts as one.
    pub(crate) fn number(&self) -> Result<f64> {
        let digits = match self.value {
            DeValue::Float(float) => float.as_str(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
            _ => return Err(self.wrong_type("a decimal number")),
        };
        let parsed = digits.parse().ok().filter(|number: &f64| number.is_finite());
        parsed.ok_or_else(|| self.out_of_range("a finite number"))
    }

    /// A finite number inside `range`.
    pub(crate) fn number_in(&self, range: RangeInclusive<f64>) -> Result<f64> {
        let number = self.number()?;
        if range.contains(&number) {
            return Ok(number);
        }
        Err(self.out_of_range(format!("{:e} to {:e}", range.start(), range.end())))
    }

    /// An integer inside `range`, as the integer type of the caller.
    pub(crate) fn integer_in<T>(&self, range: RangeInclusive<T>) -> Result<T>
    where
        T: TryFrom<i64> + PartialOrd + std::fmt::Display,
    {
        let DeValue::Integer(integer) = self.value else {
            return Err(self.wrong_type("an integer"));
        };
        let parsed = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
        let narrowed = parsed.and_then(|wide| T::try_from(wide).ok());
        narrowed
            .filter(|integer| range.contains(integer))
            .ok_or_else(|| self.out_of_range(format!("{} to {}", range.start(), range.end())))
    }

    /// One of a fixed set of words.
    pub(crate) fn word<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T> {
        let found = self.text()?;
        choices.iter().find(|(word, _)| *word == found).map(|(_, value)| *value).ok_or_else(|| {
            let words: Vec<_> = choices.iter().map(|(word, _)| format!("\"{word}\"")).collect();
            self.refuse(FrameSpecFault::UnknownWord { supported: words.join(", ") })
        })
    }
}

fn error_at(text: &str, span: Range<usize>, key: &str, fault: FrameSpecFault) -> FrameSpecError {
    let before = text.get(..span.start).unwrap_or_default();
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    FrameSpecError {
        line: before.bytes().filter(|byte| *byte == b'\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        key: key.to_owned(),
        value: quote(text.get(span).unwrap_or_default()),
        fault,
    }
}

/// The first line of `text`, cut to a length that fits a message.
fn quote(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    match line.char_indices().nth(MAX_QUOTE) {
        Some((cut, _)) => format!("{}...", &line[..cut]),
        None => line.to_owned(),
    }
}
