//! The command line: flags, options with a value, positional words, and what follows `--`.

use crate::Failure;

/// The words that no one has taken yet. Commands take what they know and call [`Args::finish`],
/// which refuses the rest, so a mistyped option is never ignored.
#[derive(Debug)]
pub(crate) struct Args {
    words: Vec<String>,
    rest: Vec<String>,
}

impl Args {
    /// The arguments of this process. Words that are not Unicode are replaced lossily; no command
    /// here needs them.
    pub(crate) fn from_env() -> Self {
        Self::new(std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()))
    }

    fn new(words: impl Iterator<Item = String>) -> Self {
        let mut words: Vec<String> = words.collect();
        let rest = match words.iter().position(|word| word == "--") {
            Some(at) => {
                let rest = words.split_off(at + 1);
                words.pop();
                rest
            }
            None => Vec::new(),
        };
        Self { words, rest }
    }

    /// Takes the first word if it is no option.
    pub(crate) fn command(&mut self) -> Option<String> {
        let is_word = self.words.first().is_some_and(|word| !word.starts_with('-'));
        is_word.then(|| self.words.remove(0))
    }

    /// Whether `--help` or `-h` stands among the words.
    pub(crate) fn wants_help(&self) -> bool {
        self.words.iter().any(|word| word == "--help" || word == "-h")
    }

    /// Takes a flag such as `--no-install`.
    pub(crate) fn flag(&mut self, name: &str) -> bool {
        let found = self.words.iter().position(|word| word == name);
        found.map(|at| self.words.remove(at)).is_some()
    }

    /// Takes `--name VALUE` or `--name=VALUE`.
    pub(crate) fn value(&mut self, name: &str) -> Result<Option<String>, Failure> {
        let joined = format!("{name}=");
        if let Some(at) = self.words.iter().position(|word| word.starts_with(&joined)) {
            return Ok(Some(self.words.remove(at)[joined.len()..].to_owned()));
        }
        let Some(at) = self.words.iter().position(|word| word == name) else {
            return Ok(None);
        };
        match self.words.get(at + 1) {
            Some(value) if !value.starts_with("--") => {
                self.words.remove(at);
                Ok(Some(self.words.remove(at)))
            }
            _ => Err(format!("{name} needs a value.")),
        }
    }

    /// As [`Args::value`], parsed; `what` names the kind of value in the error.
    pub(crate) fn parsed<T: std::str::FromStr>(
        &mut self,
        name: &str,
        what: &str,
    ) -> Result<Option<T>, Failure> {
        let Some(text) = self.value(name)? else {
            return Ok(None);
        };
        text.parse().map(Some).map_err(|_| format!("{name} needs {what}, not '{text}'."))
    }

    /// Refuses what is left, and returns what followed `--`.
    pub(crate) fn finish(self) -> Result<Vec<String>, Failure> {
        match self.words.first() {
            None => Ok(self.rest),
            Some(word) => Err(format!("'{word}' is not understood; --help shows the options.")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(line: &str) -> Args {
        Args::new(line.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn options_are_taken_in_any_order() {
        let mut args = args("demo --out=pictures --headless --frames 30 -- --key value");
        assert_eq!(args.command().as_deref(), Some("demo"));
        assert_eq!(args.parsed::<u32>("--frames", "a number"), Ok(Some(30)));
        assert!(args.flag("--headless"));
        assert!(!args.flag("--headless"), "a flag is taken once");
        assert_eq!(args.value("--out"), Ok(Some("pictures".to_owned())));
        assert_eq!(args.finish(), Ok(vec!["--key".to_owned(), "value".to_owned()]));
    }

    #[test]
    fn mistakes_are_refused() {
        assert!(args("--out").value("--out").is_err());
        assert!(args("--out --headless").value("--out").is_err());
        assert!(args("--frames many").parsed::<u32>("--frames", "a number").is_err());
        assert!(args("--framse 3").finish().is_err());
    }

    #[test]
    fn an_option_is_no_command_and_help_after_the_dashes_belongs_to_the_program() {
        assert_eq!(args("--help").command(), None);
        assert!(args("demo --help").wants_help());
        assert!(!args("demo -- --help").wants_help());
    }
}
