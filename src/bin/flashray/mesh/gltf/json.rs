//! Fields of JSON objects, with errors that name them.
use serde_json::Value;

/// The list under `key`; empty if there is none.
pub fn list<'v>(value: &'v Value, key: &str) -> Result<&'v [Value], String> {
    match value.get(key) {
        None => Ok(&[]),
        Some(Value::Array(items)) => Ok(items),
        Some(_) => Err(format!("{key} is not a list")),
    }
}

/// The item number `index` of the list under `key`.
pub fn item<'v>(value: &'v Value, key: &str, index: usize) -> Result<&'v Value, String> {
    let items = list(value, key)?;
    items.get(index).ok_or_else(|| {
        let count = items.len();
        format!("{key}: index {index} is out of range (the file has {count})")
    })
}

/// The number under `key`, which must be whole and not negative.
pub fn number(value: &Value, key: &str) -> Result<Option<u64>, String> {
    value.get(key).map(|value| whole(value, key)).transpose()
}

/// The number under `key`, which must be there.
pub fn needed(value: &Value, key: &str) -> Result<u64, String> {
    number(value, key)?.ok_or_else(|| format!("{key} is missing"))
}

/// The index under `key`.
pub fn index(value: &Value, key: &str) -> Result<Option<usize>, String> {
    number(value, key)?.map(|value| narrow(value, key)).transpose()
}

/// The indices under `key`.
pub fn indices(value: &Value, key: &str) -> Result<Vec<usize>, String> {
    list(value, key)?.iter().map(|value| narrow(whole(value, key)?, key)).collect()
}

/// The `N` numbers under `key`.
pub fn numbers<const N: usize>(value: &Value, key: &str) -> Result<Option<[f64; N]>, String> {
    if value.get(key).is_none() {
        return Ok(None);
    }
    let found: Option<Vec<f64>> = list(value, key)?.iter().map(Value::as_f64).collect();
    let found = found.and_then(|found| <[f64; N]>::try_from(found).ok());
    found.map(Some).ok_or_else(|| format!("{key} is not a list of {N} numbers"))
}

/// A whole number, also one written as `3.0`.
fn whole(value: &Value, key: &str) -> Result<u64, String> {
    /// Up to here `f64` holds every whole number.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let written_with_point = || {
        let value = value.as_f64().filter(|value| value.fract() == 0.0 && (0.0..EXACT).contains(value))?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked above")]
        let value = value as u64;
        Some(value)
    };
    value.as_u64().or_else(written_with_point).ok_or_else(|| format!("{key} is not a whole number of 0 or more"))
}

/// A number that this machine can index with.
fn narrow(value: u64, key: &str) -> Result<usize, String> {
    usize::try_from(value).map_err(|_| format!("{key} {value} is out of range"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_the_wrong_type_are_errors() {
        let value: Value = serde_json::from_str(
            r#"{"a": [1, 2.0, 3], "b": -1, "c": 1.5, "d": 7.0, "e": "x", "f": 1e300, "g": [1, "x"]}"#,
        )
        .unwrap();
        assert_eq!(indices(&value, "a"), Ok(vec![1, 2, 3]));
        assert_eq!(numbers(&value, "a"), Ok(Some([1.0, 2.0, 3.0])));
        assert_eq!(numbers::<3>(&value, "none"), Ok(None));
        assert_eq!(numbers::<2>(&value, "a").unwrap_err(), "a is not a list of 2 numbers");
        assert!(numbers::<2>(&value, "g").is_err());
        assert_eq!(number(&value, "d"), Ok(Some(7)));
        assert_eq!(needed(&value, "none").unwrap_err(), "none is missing");
        for key in ["b", "c", "e", "f", "a"] {
            assert_eq!(number(&value, key).unwrap_err(), format!("{key} is not a whole number of 0 or more"));
        }
        assert_eq!(list(&value, "b").unwrap_err(), "b is not a list");
        assert_eq!(item(&value, "a", 3).unwrap_err(), "a: index 3 is out of range (the file has 3)");
    }
}
