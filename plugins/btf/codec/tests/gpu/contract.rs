//! The structs of the shaders lie in memory as those of this crate.

use std::mem::{offset_of, size_of};

use farlight_btf_codec::{Coded, Layout, Packed};
use farlight_shaders::{compose, naga};
use naga::{Module, TypeInner};

/// Names and offsets of a struct's members, and its size.
fn described(module: &Module, name: &str) -> (Vec<(String, usize)>, usize) {
    let (_, found) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("no struct {name}"));
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
    let members = members
        .iter()
        .map(|member| (member.name.clone().unwrap(), member.offset as usize))
        .collect();
    (members, *span as usize)
}

macro_rules! same {
    ($module:expr, $type:ident { $($field:ident),* $(,)? }) => {
        let expected = vec![$((stringify!($field).to_owned(), offset_of!($type, $field))),*];
        let _exhaustive = |value: $type| { let $type { $($field: _),* } = value; };
        assert_eq!(described(&$module, stringify!($type)), (expected, size_of::<$type>()));
    };
}

#[test]
fn structs_lie_alike() {
    let module = compose("btf/layout.wgsl", &[]).unwrap();
    same!(module, Packed { offset, index_bits, min, step });
    same!(module, Coded { offset, stride, min, step });
    same!(
        module,
        Layout {
            columns,
            rows,
            flags,
            words,
            phi_count,
            theta_count,
            alpha_count,
            beta_count,
            texels,
            azimuths,
            elevations,
            luminances,
            shapes,
            colour_rows,
            chromas,
            factor,
            reserved,
        }
    );
}

#[test]
fn flags_are_the_same_numbers() {
    let module = compose("btf/layout.wgsl", &[]).unwrap();
    for (name, expected) in [("LOG_LUV", Layout::LOG_LUV), ("BETA_IN_SINE", Layout::BETA_IN_SINE)] {
        let (_, constant) = module
            .constants
            .iter()
            .find(|(_, constant)| constant.name.as_deref() == Some(name))
            .unwrap_or_else(|| panic!("no constant {name}"));
        let value = &module.global_expressions[constant.init];
        let expected = naga::Expression::Literal(naga::Literal::U32(expected));
        assert_eq!(*value, expected, "{name}");
    }
}
