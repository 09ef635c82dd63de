//! How much of each scenario is shown.

use bevy::prelude::*;

/// Most scenarios that are blended at a time.
pub const MOST_SCENARIOS: usize = 8;

/// How much of each scenario is shown: weights by the scenarios' names.
///
/// Light adds up, so weights are any numbers from 0 on and needn't sum to 1. Two ways of baking:
/// - whole states of the scene (morning, noon, evening), of which weights that sum to 1 give a mean:
///   [`blend`](Self::blend);
/// - one light each (the sun alone, a lamp alone), whose sum is the scene with both and whose weights
///   are dimmers: [`set`](Self::set) `("lamp", 0.5)` is the lamp at half its brightness.
///
/// No weights at all, the default, show the manifest's first scenario. At most [`MOST_SCENARIOS`]
/// weights above 0 count, the largest; names that the manifest lacks and weights that are negative or
/// not finite count as 0. [`BakedStatus`](crate::BakedStatus) says so.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct ScenarioWeights(Vec<(String, f32)>);

impl ScenarioWeights {
    /// Shows one scenario alone.
    pub fn show(&mut self, name: impl Into<String>) {
        self.0.clear();
        self.0.push((name.into(), 1.0));
    }

    /// Shows the mean of two: `from` at 0, `to` at 1, nothing else.
    pub fn blend(&mut self, from: impl Into<String>, to: impl Into<String>, t: f32) {
        let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 };
        self.0.clear();
        self.set(from, 1.0 - t);
        let to = to.into();
        let before = self.get(&to);
        self.set(to, before + t);
    }

    /// Sets the weight of one and leaves the others as they are.
    pub fn set(&mut self, name: impl Into<String>, weight: f32) {
        let name = name.into();
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, known)) => *known = weight,
            None => self.0.push((name, weight)),
        }
    }

    /// The weight of one, 0 where none was set.
    #[must_use]
    pub fn get(&self, name: &str) -> f32 {
        self.iter().find(|(known, _)| *known == name).map_or(0.0, |(_, weight)| weight)
    }

    /// All that were set, in the order in which they were.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f32)> {
        self.0.iter().map(|(name, weight)| (name.as_str(), *weight))
    }

    /// Weights in the order of a manifest's scenarios, and what can't be as asked.
    pub(crate) fn resolve<'a>(
        &self,
        names: impl ExactSizeIterator<Item = &'a str> + Clone,
    ) -> (Vec<f32>, Vec<String>) {
        let mut weights = vec![0.0; names.len()];
        let mut problems = Vec::new();
        if self.0.is_empty() {
            weights.iter_mut().take(1).for_each(|weight| *weight = 1.0);
            return (weights, problems);
        }
        for (name, weight) in self.iter() {
            let Some(index) = names.clone().position(|known| known == name) else {
                let known: Vec<_> = names.clone().collect();
                problems.push(format!("there is no scenario {name:?}, only {}", known.join(", ")));
                continue;
            };
            if weight.is_finite() && weight >= 0.0 {
                weights[index] = weight;
            } else {
                problems.push(format!("the weight {weight} of scenario {name:?} counts as 0"));
            }
        }
        let mut order: Vec<_> = (0..weights.len()).filter(|&i| weights[i] > 0.0).collect();
        if order.len() > MOST_SCENARIOS {
            problems.push(format!(
                "{} scenarios have a weight; the {MOST_SCENARIOS} largest weights count",
                order.len()
            ));
            order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]));
            order[MOST_SCENARIOS..].iter().for_each(|&index| weights[index] = 0.0);
        }
        (weights, problems)
    }
}

impl<N: Into<String>> FromIterator<(N, f32)> for ScenarioWeights {
    fn from_iter<I: IntoIterator<Item = (N, f32)>>(weights: I) -> Self {
        let mut all = Self::default();
        weights.into_iter().for_each(|(name, weight)| all.set(name, weight));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAY: [&str; 3] = ["morning", "noon", "lamp"];

    fn resolve(weights: &ScenarioWeights) -> (Vec<f32>, Vec<String>) {
        weights.resolve(DAY.into_iter())
    }

    #[test]
    fn weights_follow_the_manifests_order() {
        let mut weights = ScenarioWeights::default();
        assert_eq!(resolve(&weights).0, [1.0, 0.0, 0.0]);
        weights.show("noon");
        assert_eq!(resolve(&weights).0, [0.0, 1.0, 0.0]);
        weights.blend("noon", "morning", 0.25);
        weights.set("lamp", 3.0);
        assert_eq!(resolve(&weights), (vec![0.25, 0.75, 3.0], vec![]));
        weights.blend("noon", "noon", 0.25);
        assert_eq!(resolve(&weights).0, [0.0, 1.0, 0.0]);
        weights.set("noon", 0.0);
        assert_eq!(resolve(&weights).0, [0.0; 3], "darkness can be asked for");
    }

    #[test]
    fn what_cannot_be_is_said() {
        let weights: ScenarioWeights =
            [("midnight", 1.0), ("noon", f32::NAN), ("lamp", -1.0)].into_iter().collect();
        let (weights, problems) = resolve(&weights);
        assert_eq!(weights, [0.0; 3]);
        assert_eq!(problems.len(), 3);
        assert!(problems[0].contains("midnight") && problems[0].contains("morning, noon, lamp"));
    }

    #[test]
    fn the_largest_eight_count() {
        let names: Vec<String> = (0..10).map(|i| i.to_string()).collect();
        let weights: ScenarioWeights =
            names.iter().enumerate().map(|(i, name)| (name, 1.0 + i as f32)).collect();
        let (weights, problems) = weights.resolve(names.iter().map(String::as_str));
        assert_eq!(weights[..3], [0.0, 0.0, 3.0]);
        assert_eq!(problems.len(), 1);
    }
}
