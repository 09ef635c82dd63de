//! A plot with two logarithmic axes, as SVG.

use std::fmt::Write;

use farlight_environment::Method;

/// Errors of a method, one a number of lights.
pub(super) struct Curve {
    pub(super) method: Method,
    /// 0.01 for 1 %.
    pub(super) errors: Vec<f64>,
}

const SIZE: [f64; 2] = [820.0, 520.0];
/// Left, top, right and bottom of the field within the picture.
const FIELD: [f64; 4] = [80.0, 56.0, 680.0, 460.0];
/// Okabe and Ito's colours, told apart also with colour blindness.
const COLOURS: [&str; 4] = ["#d55e00", "#e69f00", "#0072b2", "#009e73"];
/// Errors below this are drawn at it.
const LEAST: f64 = 1e-7;

/// An axis from a power of ten, or part of one, to another.
struct Axis {
    least: f64,
    greatest: f64,
    /// Pixels of both ends.
    ends: [f64; 2],
}

impl Axis {
    fn at(&self, value: f64) -> f64 {
        let part = (value / self.least).ln() / (self.greatest / self.least).ln();
        self.ends[0] + (self.ends[1] - self.ends[0]) * part
    }

    /// 1, 2 and 5 times powers of ten between the ends, and whether they are powers.
    fn marks(&self) -> Vec<(f64, bool)> {
        let decades = self.least.log10().floor() as i32..=self.greatest.log10().ceil() as i32;
        decades
            .flat_map(|decade| [1.0, 2.0, 5.0].map(|m| (m * 10_f64.powi(decade), m == 1.0)))
            .filter(|(value, _)| *value >= 0.999 * self.least && *value <= 1.001 * self.greatest)
            .collect()
    }
}

/// The picture.
pub(super) fn svg(title: &str, counts: &[u32], curves: &[Curve]) -> String {
    let [left, top, right, bottom] = FIELD;
    let errors = || curves.iter().flat_map(|c| &c.errors).map(|error| error.max(LEAST));
    let [first, last] = [counts.first(), counts.last()].map(|c| f64::from(*c.unwrap_or(&1)));
    let x = Axis { least: first, greatest: last.max(1.1 * first), ends: [left, right] };
    // Up to the next mark of 1, 2, 5 would do; whole decades are easier to read.
    let y = Axis {
        least: 10_f64.powf(errors().fold(1.0, f64::min).log10().floor()),
        greatest: 10_f64.powf(errors().fold(LEAST, f64::max).log10().ceil()).max(1e-6),
        ends: [bottom, top],
    };

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{left}\" y=\"30\" font-size=\"17\">{}</text>\n",
        SIZE[0],
        SIZE[1],
        escape(title)
    );
    let mut push = |line: std::fmt::Arguments| {
        // Writing into a string does not fail.
        _ = writeln!(svg, "{line}");
    };
    for (value, whole) in y.marks() {
        let at = y.at(value);
        let colour = if whole { "#bbb" } else { "#eee" };
        push(format_args!("<path d=\"M{left} {at:.1}H{right}\" stroke=\"{colour}\"/>"));
        if whole {
            let percent = 100.0 * value;
            push(format_args!(
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{percent} %</text>",
                left - 8.0,
                at + 4.5
            ));
        }
    }
    for (value, _) in x.marks() {
        let at = x.at(value);
        push(format_args!("<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"#eee\"/>"));
        push(format_args!(
            "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{value}</text>",
            bottom + 20.0
        ));
    }
    push(format_args!(
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">lights</text>",
        0.5 * (left + right),
        bottom + 44.0
    ));
    let mut labels: Vec<(f64, usize)> = Vec::new();
    for (at, (curve, colour)) in curves.iter().zip(COLOURS).enumerate() {
        let points: Vec<[f64; 2]> = (counts.iter().zip(&curve.errors))
            .map(|(count, error)| [x.at(f64::from(*count)), y.at(error.max(LEAST))])
            .collect();
        // Not a polyline: some viewers close it.
        let line: Vec<String> = points.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
        push(format_args!(
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            line.join("L")
        ));
        for [x, y] in &points {
            push(format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>"));
        }
        labels.push((points.last().map_or(bottom, |point| point[1]), at));
    }
    // Names beside the ends of the curves, one below the other.
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = top;
    for (wanted, at) in labels {
        let line = wanted.max(free);
        free = line + 17.0;
        push(format_args!(
            "<text x=\"{}\" y=\"{:.1}\" fill=\"{}\">{}</text>",
            right + 10.0,
            line + 4.5,
            COLOURS[at],
            curves[at].method
        ));
    }
    svg + "</svg>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_stand_where_their_numbers_are() {
        let curve = |method, errors: &[f64]| Curve { method, errors: errors.to_vec() };
        let curves =
            [curve(Method::Independent, &[0.1, 0.01]), curve(Method::Centroids, &[0.01, 0.001])];
        let svg = svg("a & b", &[10, 1000], &curves);
        assert!(
            svg.contains("a &amp; b") && svg.contains(">centroids<") && svg.ends_with("</svg>\n")
        );
        // From the left to the right edge, from the upper edge to half of the height.
        assert!(svg.contains("d=\"M80.0,56.0L680.0,258.0\""), "{svg}");
        assert!(svg.contains("d=\"M80.0,258.0L680.0,460.0\""), "{svg}");
        assert!(svg.contains(">1 %<") && svg.contains(">10 %<") && svg.contains(">500<"));
    }

    #[test]
    fn odd_numbers_make_no_odd_picture() {
        let curves = [Curve { method: Method::Regions, errors: vec![0.0] }];
        let svg = svg("", &[1], &curves);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
