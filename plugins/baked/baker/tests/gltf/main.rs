//! glTF in, glTF out.

mod check;
mod fuzz;
mod glb;
mod sets;
mod whole;
