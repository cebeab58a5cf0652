//! Tables and values that know their place in the file.

use crate::{Fault, Result, SettingsError};
use std::ops::{Range, RangeInclusive};
use toml::de::{DeTable, DeValue};

/// A settings file is some pages of text; anything longer is a mistake or an attack.
const MAX_TEXT_LEN: usize = 256 * 1024;
/// Characters of a refused value that an error repeats.
const MAX_QUOTE: usize = 40;

/// A word must be at least this much like another to be proposed in its place.
const LIKENESS_MIN: f64 = 0.75;

/// One table of the file.
#[derive(Debug, Clone)]
pub struct Table<'a> {
    text: &'a str,
    path: String,
    span: Range<usize>,
    entries: &'a DeTable<'a>,
}

/// One value of the file.
#[derive(Debug, Clone)]
pub struct Value<'a> {
    text: &'a str,
    path: String,
    span: Range<usize>,
    value: &'a DeValue<'a>,
}

/// Parses `text` and hands its root table to `read`.
///
/// # Errors
/// [`SettingsError`] when the text is too long or no TOML, and whatever `read` refuses.
pub fn read<T>(text: &str, read: impl FnOnce(&Table<'_>) -> Result<T>) -> Result<T> {
    if text.len() > MAX_TEXT_LEN {
        let fault = Fault::TooLong { found: text.len(), limit: MAX_TEXT_LEN };
        return Err(error_at(text, 0..0, "file", fault));
    }
    let root = DeTable::parse(text).map_err(|error| {
        let fault = Fault::Syntax { message: error.message().to_owned() };
        error_at(text, error.span().unwrap_or(0..0), "file", fault)
    })?;
    read(&Table { text, path: String::new(), span: root.span(), entries: root.get_ref() })
}

impl<'a> Table<'a> {
    /// Refuses every key outside `known`, naming the nearest known one.
    ///
    /// # Errors
    /// [`Fault::UnknownKey`] for the first such key.
    pub fn only(&self, known: &[&str]) -> Result<()> {
        for (key, _) in self.entries {
            if !known.contains(&key.get_ref().as_ref()) {
                let nearest = nearest(key.get_ref(), known.iter().copied());
                let fault = Fault::UnknownKey { nearest, known: known.join(", ") };
                let path = self.path_of(&quote(key.get_ref()));
                return Err(error_at(self.text, key.span(), &path, fault));
            }
        }
        Ok(())
    }

    /// The value of `key`, if it is there.
    #[must_use]
    pub fn optional(&self, key: &str) -> Option<Value<'a>> {
        let (_, value) = self.entries.iter().find(|(found, _)| found.get_ref() == key)?;
        let path = self.path_of(key);
        Some(Value { text: self.text, path, span: value.span(), value: value.get_ref() })
    }

    /// The value of `key`.
    ///
    /// # Errors
    /// [`Fault::Missing`] when it is not there.
    pub fn required(&self, key: &str) -> Result<Value<'a>> {
        self.optional(key).ok_or_else(|| {
            error_at(self.text, self.span.clone(), &self.path_of(key), Fault::Missing)
        })
    }

    /// The tables of an array of tables, at most `most`; none when the key is absent.
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::OutOfRange`].
    pub fn tables(&self, key: &str, most: usize) -> Result<Vec<Table<'a>>> {
        let Some(value) = self.optional(key) else { return Ok(Vec::new()) };
        let items = value.array()?;
        if items.len() > most {
            return Err(value.out_of_range(format!("at most {most} of them")));
        }
        items.iter().map(Value::table).collect()
    }

    /// A refusal of the table as a whole, for the given reason.
    #[must_use]
    pub fn because(&self, reason: impl Into<String>) -> Box<SettingsError> {
        let fault = Fault::Refused { reason: reason.into() };
        error_at(self.text, self.span.clone(), &self.path, fault)
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }
}

impl<'a> Value<'a> {
    /// A refusal of this value.
    #[must_use]
    pub fn refuse(&self, fault: Fault) -> Box<SettingsError> {
        error_at(self.text, self.span.clone(), &self.path, fault)
    }

    /// A refusal of this value, for the given reason.
    #[must_use]
    pub fn because(&self, reason: impl Into<String>) -> Box<SettingsError> {
        self.refuse(Fault::Refused { reason: reason.into() })
    }

    /// A refusal of this value that says what would be accepted.
    #[must_use]
    pub fn out_of_range(&self, expected: impl Into<String>) -> Box<SettingsError> {
        self.refuse(Fault::OutOfRange { expected: expected.into() })
    }

    fn wrong_type(&self, expected: &'static str) -> Box<SettingsError> {
        self.refuse(Fault::WrongType { found: self.value.type_str(), expected })
    }

    /// Path of the key, such as `frame.field[1].bits`.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The value as a table.
    ///
    /// # Errors
    /// [`Fault::WrongType`] when it is something else.
    pub fn table(&self) -> Result<Table<'a>> {
        let entries = self.value.as_table().ok_or_else(|| self.wrong_type("a table"))?;
        Ok(Table { text: self.text, path: self.path.clone(), span: self.span.clone(), entries })
    }

    /// The elements of an array.
    ///
    /// # Errors
    /// [`Fault::WrongType`] when it is something else.
    pub fn array(&self) -> Result<Vec<Self>> {
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
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::OutOfRange`].
    pub fn pair(&self) -> Result<[Self; 2]> {
        self.array()?.try_into().map_err(|_| self.out_of_range("two numbers, [first, last]"))
    }

    /// The value as text.
    ///
    /// # Errors
    /// [`Fault::WrongType`] when it is something else.
    pub fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a \"string\""))
    }

    /// The value as true or false.
    ///
    /// # Errors
    /// [`Fault::WrongType`] when it is something else.
    pub fn boolean(&self) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    /// A finite number; an integer counts as one.
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::OutOfRange`].
    pub fn number(&self) -> Result<f64> {
        let digits = match self.value {
            DeValue::Float(float) => float.as_str(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
            _ => return Err(self.wrong_type("a decimal number")),
        };
        let parsed = digits.parse().ok().filter(|number: &f64| number.is_finite());
        parsed.ok_or_else(|| self.out_of_range("a finite number"))
    }

    /// A finite number greater than 0.
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::OutOfRange`].
    pub fn positive(&self) -> Result<f64> {
        let number = self.number()?;
        if number > 0.0 { Ok(number) } else { Err(self.out_of_range("a number greater than 0")) }
    }

    /// A finite number, 0 or greater.
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::OutOfRange`].
    pub fn not_negative(&self) -> Result<f64> {
        let number = self.number()?;
        if number >= 0.0 { Ok(number) } else { Err(self.out_of_range("0 or a greater number")) }
    }

    /// A finite number inside `range`.
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::OutOfRange`].
    pub fn number_in(&self, range: RangeInclusive<f64>) -> Result<f64> {
        let number = self.number()?;
        if range.contains(&number) {
            return Ok(number);
        }
        Err(self.out_of_range(format!("{:e} to {:e}", range.start(), range.end())))
    }

    /// An integer inside `range`, as the integer type of the caller.
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::OutOfRange`].
    pub fn integer_in<T>(&self, range: RangeInclusive<T>) -> Result<T>
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
    ///
    /// # Errors
    /// [`Fault::WrongType`] or [`Fault::UnknownWord`].
    pub fn word<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T> {
        let found = self.text()?;
        choices.iter().find(|(word, _)| *word == found).map(|(_, value)| *value).ok_or_else(|| {
            let words: Vec<_> = choices.iter().map(|(word, _)| format!("\"{word}\"")).collect();
            let nearest = nearest(found, choices.iter().map(|(word, _)| *word));
            self.refuse(Fault::UnknownWord { nearest, supported: words.join(", ") })
        })
    }
}

fn error_at(text: &str, span: Range<usize>, key: &str, fault: Fault) -> Box<SettingsError> {
    let before = text.get(..span.start).unwrap_or_default();
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    Box::new(SettingsError {
        file: None,
        line: before.bytes().filter(|byte| *byte == b'\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        key: key.to_owned(),
        value: quote(text.get(span).unwrap_or_default()),
        fault,
    })
}

/// The first line of `text`, cut to a length that fits a message.
fn quote(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    match line.char_indices().nth(MAX_QUOTE) {
        Some((cut, _)) => format!("{}...", &line[..cut]),
        None => line.to_owned(),
    }
}

/// The known word most like `word`, if any is alike at all.
fn nearest<'k>(word: &str, known: impl Iterator<Item = &'k str>) -> Option<String> {
    let likeness = |known: &'k str| (strsim::jaro_winkler(word, known), known);
    let best = known.map(likeness).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= LIKENESS_MIN).then(|| best.1.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_unknown_key_is_refused_with_the_nearest_known_one() {
        let text = "# a comment\n\n[run]\nduratoin_s = 5\n";
        let refusal =
            read(text, |root| root.required("run")?.table()?.only(&["name", "duration_s", "seed"]))
                .unwrap_err();
        assert_eq!((refusal.line, refusal.column), (4, 1));
        assert_eq!(refusal.key, "run.duratoin_s");
        let Fault::UnknownKey { nearest, .. } = refusal.fault else { panic!("{refusal}") };
        assert_eq!(nearest.as_deref(), Some("duration_s"));
    }

    #[test]
    fn a_word_like_nothing_known_gets_no_proposal() {
        assert_eq!(nearest("zzz", ["duration_s", "seed"].into_iter()), None);
    }

    #[test]
    fn a_nan_is_no_number_here() {
        for text in ["x = nan", "x = inf", "x = -inf", "x = \"1\"", "x = 1e999"] {
            assert!(read(text, |root| root.required("x")?.number()).is_err(), "{text}");
        }
    }

    #[test]
    fn a_refusal_names_its_file() {
        let refusal = read("x = 1", |root| root.required("y").map(|_| ())).unwrap_err();
        let text = refusal.in_file(std::path::Path::new("a.toml")).to_string();
        assert!(text.starts_with("a.toml, line 1"), "{text}");
    }

    proptest! {
        #[test]
        fn no_text_panics(text in ".{0,200}") {
            let _ = read(&text, |root| root.only(&["x"]));
        }

        #[test]
        fn integers_come_back_or_are_refused(wide in any::<i64>()) {
            let read = read(&format!("x = {wide}"), |root| {
                root.required("x")?.integer_in(-100_i32..=100)
            });
            prop_assert_eq!(read.is_ok(), (-100..=100).contains(&wide));
        }
    }
}
