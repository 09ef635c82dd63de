//! Bindings in files.

use std::{collections::BTreeMap, fmt};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser::SerializeStruct};

use crate::{ActionBindings, Binding};

impl Serialize for Binding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.is_plain() {
            return serializer.serialize_str(&self.input_text());
        }
        let plain = Self::new(self.source);
        let mut fields = serializer.serialize_struct("Binding", 6)?;
        fields.serialize_field("input", &self.input_text())?;
        if self.dead_zone != plain.dead_zone {
            fields.serialize_field("dead_zone", &self.dead_zone)?;
        }
        if self.curve != plain.curve {
            fields.serialize_field("curve", &self.curve)?;
        }
        if self.scale != plain.scale {
            fields.serialize_field("scale", &self.scale)?;
        }
        if self.invert_x {
            fields.serialize_field("invert_x", &true)?;
        }
        if self.invert_y {
            fields.serialize_field("invert_y", &true)?;
        }
        fields.end()
    }
}

impl<'de> Deserialize<'de> for Binding {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Binding;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an input such as \"KeyM\", or (input: \"LeftStick\", scale: 90.0)")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Binding, E> {
                text.parse().map_err(E::custom)
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Binding, A::Error> {
                let fields = Fields::deserialize(de::value::MapAccessDeserializer::new(map))?;
                let mut binding = fields.input;
                binding.dead_zone = fields.dead_zone.unwrap_or(binding.dead_zone);
                binding.curve = fields.curve.unwrap_or(binding.curve);
                binding.scale = fields.scale.unwrap_or(binding.scale);
                binding.invert_x = fields.invert_x;
                binding.invert_y = fields.invert_y;
                Ok(binding)
            }
        }

        deserializer.deserialize_any(Visitor)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    #[serde(deserialize_with = "text")]
    input: Binding,
    #[serde(default, deserialize_with = "some")]
    dead_zone: Option<f32>,
    #[serde(default, deserialize_with = "some")]
    curve: Option<f32>,
    #[serde(default, deserialize_with = "some")]
    scale: Option<f32>,
    #[serde(default)]
    invert_x: bool,
    #[serde(default)]
    invert_y: bool,
}

/// A text, read where it stands, so that errors say where.
fn text<'de, D: Deserializer<'de>>(from: D) -> Result<Binding, D::Error> {
    String::deserialize(from)?.parse().map_err(de::Error::custom)
}

/// What is there, without `Some()` round it.
fn some<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Option<T>, D::Error> {
    T::deserialize(from).map(Some)
}

/// Most bindings of an action on a device.
pub(crate) const MAX_BINDINGS: usize = 16;
/// Most actions of a file.
pub(crate) const MAX_ACTIONS: usize = 512;

/// Lists of bindings, without `Some()` round them; one binding needs no brackets.
pub(crate) mod list {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(
        list: &Option<Vec<Binding>>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        // What is `None` is skipped.
        list.as_deref().unwrap_or_default().serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<Vec<Binding>>, D::Error> {
        struct Visitor;

        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Vec<Binding>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of inputs such as [\"KeyM\"]")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Vec<Binding>, E> {
                Ok(vec![text.parse().map_err(E::custom)?])
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Vec<Binding>, A::Error> {
                let map = de::value::MapAccessDeserializer::new(map);
                Binding::deserialize(map).map(|binding| vec![binding])
            }

            fn visit_seq<A: de::SeqAccess<'de>>(
                self,
                mut seq: A,
            ) -> Result<Vec<Binding>, A::Error> {
                let mut list = Vec::new();
                while let Some(binding) = seq.next_element()? {
                    if list.len() == MAX_BINDINGS {
                        return Err(de::Error::custom(format_args!(
                            "more than {MAX_BINDINGS} bindings of one action"
                        )));
                    }
                    list.push(binding);
                }
                Ok(list)
            }
        }

        deserializer.deserialize_any(Visitor).map(Some)
    }
}

/// Names of actions.
pub(crate) fn names<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<String>, D::Error> {
    struct Visitor;

    impl<'de> de::Visitor<'de> for Visitor {
        type Value = Vec<String>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a list of actions such as [\"pan\", \"rise\"]")
        }

        fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
            let mut names = Vec::new();
            while let Some(name) = seq.next_element()? {
                if names.len() == MAX_ACTIONS {
                    return Err(de::Error::custom(format_args!("more than {MAX_ACTIONS} actions")));
                }
                names.push(name);
            }
            Ok(names)
        }
    }

    from.deserialize_seq(Visitor)
}

/// Every action once.
pub(crate) fn unique<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, ActionBindings>, D::Error> {
    struct Visitor;

    impl<'de> de::Visitor<'de> for Visitor {
        type Value = BTreeMap<String, ActionBindings>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("actions and their inputs, such as {\"menu\": (gamepad: [\"Start\"])}")
        }

        fn visit_map<A: de::MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut actions = BTreeMap::new();
            while let Some(name) = map.next_key::<String>()? {
                let short: String = name.chars().take(40).collect();
                if actions.contains_key(&name) {
                    return Err(de::Error::custom(format_args!("{short:?} is there twice")));
                }
                if actions.len() == MAX_ACTIONS {
                    return Err(de::Error::custom(format_args!("more than {MAX_ACTIONS} actions")));
                }
                actions.insert(name, map.next_value()?);
            }
            Ok(actions)
        }
    }

    deserializer.deserialize_map(Visitor)
}
