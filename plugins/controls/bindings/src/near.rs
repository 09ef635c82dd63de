//! What somebody may have meant.

/// The name with the fewest differences, if they are few.
pub(crate) fn nearest<S: AsRef<str>>(
    name: &str,
    names: impl IntoIterator<Item = S>,
) -> Option<String> {
    if name.len() > 64 {
        return None;
    }
    let names = names.into_iter();
    let near = names.map(|near| (edits(name, near.as_ref()), near.as_ref().to_owned()));
    let (distance, near) = near.min()?;
    // A third of the letters may be wrong, and three of them.
    (distance <= 3 && distance * 3 <= name.chars().count().max(3)).then_some(near)
}

/// `; did you mean KeyM?`, or nothing.
pub(crate) fn meant(near: Option<&str>) -> String {
    near.map(|near| format!("; did you mean {near}?")).unwrap_or_default()
}

/// Levenshtein's distance, without regard to case.
fn edits(a: &str, b: &str) -> usize {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut before = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let change = before + usize::from(x != *y);
            before = row[j + 1];
            row[j + 1] = change.min(before + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
