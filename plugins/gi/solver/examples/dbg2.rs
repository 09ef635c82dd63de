use farlight_gi_solver::*;
use glam::*;
fn main(){
 let tris: Vec<[Vec3;3]> = (0..8).map(|i| { let o=Vec3::X*(2.0*i as f32); [o,o+Vec3::X,o+Vec3::Y] }).collect();
 let t=Tracer::new(&tris);
 for i in 0..8 { let h=t.closest(&Ray::new(Vec3::new(0.2+2.0*i as f32,0.5,1.0),Vec3::NEG_Z)); println!("{h:?}");}
}
