//! The guard around the reader crates: a panic in one of them becomes an error of one line.
//!
//! tobj and gltf can panic on hostile files (an index out of range, an overflow), and a reader that gives up must not
//! take the command down or print a trace.
use std::cell::Cell;
use std::fmt::Display;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

/// The most characters of a crate's message that are passed on: some hold a whole line of the file.
const LONGEST: usize = 160;

thread_local! {
    /// True while this thread is inside [`guarded`].
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Calls `read`. Its error becomes one short line, and so does a panic, which prints nothing.
pub fn guarded<T, E: Display>(read: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    silence();
    let outer = GUARDED.replace(true);
    // What `read` may leave half done is dropped with the error.
    let result = panic::catch_unwind(AssertUnwindSafe(read));
    GUARDED.set(outer);
    match result {
        Ok(result) => result.map_err(short),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Err(format!("the reader gave up on this file ({})", short(text.unwrap_or("for no stated reason"))))
        }
    }
}

/// Puts a panic hook in place that is silent inside [`guarded`] and else does what the one before it did.
fn silence() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !GUARDED.get() {
                previous(info);
            }
        }));
    });
}

/// `message` as one line, cut if it is long.
pub fn short(message: impl Display) -> String {
    let words: Vec<String> = message.to_string().split_whitespace().map(String::from).collect();
    let line = words.join(" ");
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", line.get(..end).unwrap_or_default()),
        None => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_become_errors() {
        let number = std::hint::black_box(3);
        let error = guarded(|| Ok::<_, String>([1, 2][number])).unwrap_err();
        let why = "index out of bounds: the len is 2 but the index is 3";
        assert_eq!(error, format!("the reader gave up on this file ({why})"));
        assert_eq!(guarded(|| guarded(|| -> Result<i32, String> { panic!("a\nb") }).or(Ok::<_, String>(7))), Ok(7));
        assert!(!GUARDED.get());
    }

    #[test]
    fn errors_become_short_lines() {
        assert_eq!(guarded(|| Err::<(), _>("a\n\tb ")), Err("a b".into()));
        assert_eq!(short("\u{e4}".repeat(999)).chars().count(), LONGEST + 3);
    }
}
