//! The text of a manifest.

use serde::Serialize;

use super::{Manifest, ManifestError, Scenario};

/// What the text begins with; it tells what the file is.
pub(super) const NAME: &str = "BakedManifest";

impl Manifest {
    /// Reads and checks a manifest.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn parse(text: &str) -> Result<Self, ManifestError> {
        let manifest: Self =
            ron::from_str(text).map_err(|error| ManifestError::Syntax(error.to_string()))?;
        manifest.validate()?;
        Ok(manifest)
    }

    /// The text of a manifest: a receiver, a volume, a page, a light a line, so that many stay readable
    /// and a change is a change of few lines.
    #[must_use]
    pub fn to_text(&self) -> String {
        // All fields by name: one that is added without a line here fails to compile.
        let Self {
            version,
            scene,
            input,
            complete,
            settings,
            page_size,
            pages,
            receivers,
            left_out,
            volumes,
            scenarios,
        } = self;
        let mut text = Text { text: format!("{NAME}(\n"), indent: 1 };
        text.field("version", version);
        text.field("scene", scene);
        text.field("input", input);
        text.field("complete", complete);
        text.field("settings", settings);
        text.field("page_size", page_size);
        text.field("pages", pages);
        text.list("receivers", receivers, Text::item);
        text.list("left_out", left_out, Text::item);
        text.list("volumes", volumes, Text::item);
        text.list("scenarios", scenarios, Text::scenario);
        text.text + ")\n"
    }
}

/// A text that grows by lines.
struct Text {
    text: String,
    indent: usize,
}

impl Text {
    fn line(&mut self, line: &str) {
        self.text.extend(std::iter::repeat_n("    ", self.indent));
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn item<T: Serialize>(&mut self, value: &T) {
        self.line(&format!("{},", flat(value)));
    }

    fn field<T: Serialize>(&mut self, name: &str, value: &T) {
        self.line(&format!("{name}: {},", flat(value)));
    }

    /// A value after the other, each on lines of its own.
    fn list<T>(&mut self, name: &str, values: &[T], item: impl Fn(&mut Self, &T)) {
        if values.is_empty() {
            self.line(&format!("{name}: [],"));
            return;
        }
        self.line(&format!("{name}: ["));
        self.indent += 1;
        for value in values {
            item(self, value);
        }
        self.indent -= 1;
        self.line("],");
    }

    fn scenario(&mut self, scenario: &Scenario) {
        let Scenario { name, pages, volumes, lights, sky, samples, relative_error } = scenario;
        self.line("(");
        self.indent += 1;
        self.field("name", name);
        self.list("pages", pages, Self::item);
        self.list("volumes", volumes, Self::item);
        self.list("lights", lights, Self::item);
        self.field("sky", sky);
        self.field("samples", samples);
        self.field("relative_error", relative_error);
        self.indent -= 1;
        self.line("),");
    }
}

/// A value on one line.
fn flat<T: Serialize>(value: &T) -> String {
    let style = ron::ser::PrettyConfig::new().depth_limit(0);
    // Plain data: there is nothing that RON can't hold.
    ron::ser::to_string_pretty(value, style).unwrap_or_default()
}
