#[path = "../tests/common/mod.rs"]
mod common;
use farlight_gi_solver::*;
use glam::*;
fn main(){
    let mut b = common::Builder::default();
    b.room(Vec3::ZERO, Vec3::new(2.0, 3.0, 4.0), [Vec3::splat(0.5); 6], Vec3::ONE);
    let mut session = b.session(common::small());
    for _ in 0..1000 { if let Some(u)=session.step() { println!("{} tiles, {:?}", u.tiles.len(), u.quality);} if session.is_idle(){break;} }
    println!("{}", session.debug());
    for t in session.texels().iter().step_by(100) { println!("{t:?}"); }
}
