//! Numbers as scenarios write them: with defaults, in pairs and triples.

use struna_settings::{Result, Table, Value};

/// The value of `key`, or `default` when it is absent.
pub(super) fn or<'a, T>(
    table: &Table<'a>,
    key: &str,
    get: impl Fn(&Value<'a>) -> Result<T>,
    default: T,
) -> Result<T> {
    table.optional(key).map_or(Ok(default), |value| get(&value))
}

/// What `read` makes of the table called `key`, or nothing when it is absent.
pub(super) fn section<'a, T>(
    table: &Table<'a>,
    key: &str,
    read: impl Fn(&Table<'a>) -> Result<T>,
) -> Result<Option<T>> {
    table.optional(key).map(|value| read(&value.table()?)).transpose()
}

/// Two numbers, each read by `get`.
pub(super) fn pair<'a>(
    value: &Value<'a>,
    get: impl Fn(&Value<'a>) -> Result<f64>,
) -> Result<[f64; 2]> {
    let items = value.array()?;
    let [x, y] = items.as_slice() else {
        return Err(value.out_of_range("two numbers, [x, y]"));
    };
    Ok([get(x)?, get(y)?])
}

/// Three numbers, each read by `get`.
pub(super) fn triple<'a>(
    value: &Value<'a>,
    get: impl Fn(&Value<'a>) -> Result<f64>,
) -> Result<[f64; 3]> {
    let items = value.array()?;
    let [x, y, z] = items.as_slice() else {
        return Err(value.out_of_range("three numbers, [x, y, z]"));
    };
    Ok([get(x)?, get(y)?, get(z)?])
}
