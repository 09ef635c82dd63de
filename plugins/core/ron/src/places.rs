//! Where in a RON text a field is, and which field is where: what a parser alone can't say.

/// Deeper texts are no settings.
const DEEPEST: usize = 12;
/// More of a name is not shown.
const LONGEST: usize = 64;

/// A place in a text: line and column in characters, from 1.
pub type Place = (usize, usize);

/// The field at a place: `bindings.orbit.gamepad[0].scale`; empty outside of all fields.
pub fn field_at(text: &str, place: Place) -> String {
    let mut path = String::new();
    scan(text, |at, now| {
        if at <= place {
            path = join(now);
        }
        at <= place
    });
    path
}

/// Where a field is (`bindings.orbit.gamepad[0]`), or the nearest one round it; `None` if there is none.
pub fn place_of(text: &str, field: &str) -> Option<Place> {
    let mut best = None;
    scan(text, |at, now| {
        let path = join(now);
        let around = field.strip_prefix(path.as_str());
        let around = around.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']));
        let better = best.as_ref().is_none_or(|(length, _)| path.len() > *length);
        if !path.is_empty() && around && better {
            best = Some((path.len(), at));
        }
        best.as_ref().is_none_or(|(length, _)| *length < field.len())
    });
    best.map(|(_, place)| place)
}

/// Where the token begins that a parser means: behind white space, and with its quotation mark.
pub(crate) fn token_at(text: &str, (line, column): Place) -> Place {
    let Some(content) = text.lines().nth(line.saturating_sub(1)) else { return (line, column) };
    let before = content.chars().nth(column.wrapping_sub(2));
    if before == Some('"') {
        return (line, column - 1);
    }
    let blank = content.chars().skip(column.saturating_sub(1)).take_while(|c| c.is_whitespace());
    (line, column + blank.count())
}

/// One level of brackets.
struct Level {
    list: bool,
    /// No token of the item was seen yet.
    fresh: bool,
    /// What is being set: a name, or a place in a list.
    now: Step,
}

enum Step {
    None,
    Name(String),
    Item(usize),
}

fn join(levels: &[Level]) -> String {
    let mut path = String::new();
    for level in levels {
        match &level.now {
            Step::None => {}
            Step::Name(name) if path.is_empty() => path += name,
            Step::Name(name) => path += &format!(".{name}"),
            Step::Item(at) => path += &format!("[{at}]"),
        }
    }
    path
}

/// Tells `visit` every place where another field begins, until it says no.
fn scan(text: &str, mut visit: impl FnMut(Place, &[Level]) -> bool) {
    let mut levels: Vec<Level> = Vec::new();
    let mut rest = text;
    let mut place = (1, 1);
    let mut word: Option<(Place, String)> = None;
    while let Some(first) = rest.chars().next() {
        let length = token(rest, first);
        let (this, after) = rest.split_at(length.clamp(first.len_utf8(), rest.len()));
        let mut go = true;
        let content = !first.is_whitespace() && !matches!(first, '/' | ',' | ']');
        if let Some(level) = levels.last_mut().filter(|level| level.fresh && content) {
            level.fresh = false;
            go = visit(place, &levels);
        }
        match first {
            '(' | '[' | '{' => {
                if levels.len() == DEEPEST {
                    return;
                }
                let list = first == '[';
                let now = if list { Step::Item(0) } else { Step::None };
                levels.push(Level { list, fresh: list, now });
                word = None;
            }
            ')' | ']' | '}' => {
                levels.pop();
                word = None;
            }
            ',' => {
                word = None;
                if let Some(level) = levels.last_mut() {
                    level.fresh = level.list;
                    level.now = match level.now {
                        Step::Item(at) => Step::Item(at + 1),
                        _ => Step::None,
                    };
                    if !level.list {
                        go = go && visit(place, &levels);
                    }
                }
            }
            ':' => {
                if let (Some((at, name)), Some(level)) = (word.take(), levels.last_mut())
                    && !level.list
                {
                    level.now = Step::Name(name);
                    go = go && visit(at, &levels);
                }
            }
            '"' => {
                word = Some((place, this.trim_matches('"').chars().take(LONGEST).collect()));
            }
            c if c.is_alphanumeric() || c == '_' => {
                word = Some((place, this.chars().take(LONGEST).collect()));
            }
            _ => {}
        }
        if !go {
            return;
        }
        for c in this.chars() {
            place = if c == '\n' { (place.0 + 1, 1) } else { (place.0, place.1 + 1) };
        }
        rest = after;
    }
}

/// How long the token is at the beginning of a text.
fn token(text: &str, first: char) -> usize {
    let quoted = |from: usize| {
        let mut escaped = false;
        let end = text[from..].find(|c| {
            let end = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            end
        });
        end.map_or(text.len(), |end| from + end + 1)
    };
    match first {
        '"' => quoted(1),
        '/' if text.starts_with("//") => text.find('\n').unwrap_or(text.len()),
        '/' if text.starts_with("/*") => text[2..].find("*/").map_or(text.len(), |end| end + 4),
        c if c.is_alphanumeric() || c == '_' => {
            text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len())
        }
        c => c.len_utf8(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"// bindings: no
ControlsSettings(
    invert_zoom: true, /* sensitivity: 1,
    */ sensitivity: 2.0,
    bindings: {
        "orbit": (gamepad: ["KeyA:\"(", (input: "KeyB", scale: 1.0)]),
        "zoom": (gamepad: []),
    },
)"#;

    #[test]
    fn fields_are_found_by_place() {
        for (place, field) in [
            ((1, 5), ""),
            ((3, 18), "invert_zoom"),
            ((4, 23), "sensitivity"),
            ((6, 10), "bindings.orbit"),
            ((6, 29), "bindings.orbit.gamepad[0]"),
            ((6, 41), "bindings.orbit.gamepad[1]"),
            ((6, 58), "bindings.orbit.gamepad[1].scale"),
            ((7, 27), "bindings.zoom.gamepad"),
        ] {
            assert_eq!(field_at(TEXT, place), field, "{place:?}");
        }
    }

    #[test]
    fn places_are_found_by_field() {
        for (field, place) in [
            ("sensitivity", Some((4, 8))),
            ("bindings.orbit", Some((6, 9))),
            ("bindings.orbit.gamepad", Some((6, 19))),
            ("bindings.orbit.gamepad[0]", Some((6, 29))),
            ("bindings.orbit.gamepad[1]", Some((6, 41))),
            ("bindings.orbit.gamepad[1].scale", Some((6, 57))),
            ("bindings.zoom.gamepad", Some((7, 18))),
            // The nearest one round it.
            ("bindings.zoom.touch[3]", Some((7, 9))),
            ("preset", None),
        ] {
            assert_eq!(place_of(TEXT, field), place, "{field}");
        }
    }
}
