//! draft
mod align; mod catalogue; mod check; mod counter; mod discover; mod field; mod frames; mod layout; mod length; mod rate; mod septet;
pub use layout::*; pub use length::length_score; pub use catalogue::Crc;
/// d
pub fn draft(bytes:&[u8]) -> Option<Layout> { discover::discover(bytes).map(|d| d.layout) }
/// d
pub fn debug(bytes:&[u8]) { 
 for c in length::candidates(bytes) { 
   let f = length::widen(bytes, c.len).unwrap();
   eprintln!("len {} saved {:.3} cov {:.3} wide {:.3} {:.3} rows {}", c.len, c.saved, c.coverage, f.saved, f.coverage, f.starts.len());
   let rows = frames::Frames::new(bytes, f.len, f.starts.clone(), 8, false);
   let k = rows.constant(None);
   eprintln!("   const {:?} places {:?}", k.iter().map(|c| u8::from(*c)).collect::<Vec<_>>(), check::search(bytes, &f, &k, false));
   if c.len > 30 {break;}
 }
}
