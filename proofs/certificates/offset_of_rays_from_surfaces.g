# offset_of_rays_from_surfaces (RG-3): A ray from a point at an f32 distance within 2u of the true one begins beyond the plane of its surface, on the side to which it goes.
# Of model/spec/src/rays/camera.rs: 14 steps of u c, u = 2^-24, c the largest coordinate.
{ |w| <= 2
  /\ |p| <= 1
  /\ |t| <= 0x2p-24
  /\ |r1| <= 0x1p-24 /\ |r2| <= 0x1p-24 /\ |r3| <= 0x1p-24 /\ |r4| <= 0x1p-24
  /\ m in [0x1fffff00000000p-53, 0x10000080000000p-52]
  -> 1.7321 * ((|w| * |(1 + t) * (1 + r1) - 1| + |p| * |r2|) + (|p| + 0x1c000000000000p-73) * |r4| + 0x1c000000000000p-73 * |r3|) - 0x1c000000000000p-73 * m <= 0 }
