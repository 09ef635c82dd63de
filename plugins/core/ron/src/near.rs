//! What somebody may have meant.

/// The name with the fewest differences, if they are few: at most three, and a third of the letters.
pub fn nearest<S: AsRef<str>>(name: &str, names: impl IntoIterator<Item = S>) -> Option<String> {
    if name.len() > 64 {
        return None;
    }
    let names = names.into_iter();
    let near = names.map(|near| (edits(name, near.as_ref()), near.as_ref().to_owned()));
    let (distance, near) = near.min()?;
    // A third of the letters may be wrong, and three of them.
    (distance <= 3 && distance * 3 <= name.chars().count()).then_some(near)
}

/// `; did you mean KeyM?`, or nothing.
pub fn meant(near: Option<&str>) -> String {
    near.map(|near| format!("; did you mean {near}?")).unwrap_or_default()
}

/// How many letters are missing, too many, wrong, or exchanged with the next one, without regard to
/// case: Damerau and Levenshtein's distance of optimal string alignment.
fn edits(a: &str, b: &str) -> usize {
    let letters = |text: &str| text.to_lowercase().chars().collect::<Vec<_>>();
    let (a, b) = (letters(a), letters(b));
    let mut before: Vec<usize> = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 0..a.len() {
        let mut row = vec![i + 1];
        for j in 0..b.len() {
            let change = last[j] + usize::from(a[i] != b[j]);
            let mut least = change.min(last[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j] {
                least = least.min(before[j - 1] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised() {
        assert_eq!(edits("menu", "mneu"), 1);
        assert_eq!(edits("menu", "MENU"), 0);
        assert_eq!(edits("", "menu"), 4);
        assert_eq!(edits("orbit", "orbot"), 1);
        assert_eq!(edits("kitten", "sitting"), 3);
        let names = ["menu", "orbit", "previous_material", "x"];
        assert_eq!(nearest("previoux_materiak", names).as_deref(), Some("previous_material"));
        assert_eq!(nearest("mnu", names).as_deref(), Some("menu"));
        assert_eq!(nearest("jump", names), None);
        assert_eq!(nearest("", names), None);
        assert_eq!(nearest(&"m".repeat(1000), names), None);
    }
}
