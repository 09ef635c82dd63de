//! glTF in, glTF out.

// The importer's tests have the same files to make and to damage.
#[path = "../../../../gi/solver/tests/common/glb.rs"]
mod builder;
mod check;
#[path = "../../../../gi/solver/tests/common/damage.rs"]
mod damage;
mod fuzz;
mod glb;
mod sets;
mod whole;
