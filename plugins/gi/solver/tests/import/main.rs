//! Reading glTF: what files mean, and what happens to broken and hostile ones.

#[path = "../common/glb.rs"]
mod builder;
#[path = "../common/damage.rs"]
mod damage;
mod features;
mod fuzz;
mod glb;
mod hostile;
mod memory;
mod reference;

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;
