# normal_exact_edges (IS-3): With exact edges, it is off by so much of the sum of both products without signs.
# Of model/fast/src/adaptive/bounds.rs: 3 steps of u², u = 2^-53.
{ |a| <= 0x1p-53 /\ |b| <= 0x1p-53 /\ |c| <= 0x1p-53
  /\ |y| <= 1
  -> |y * ((b - a) * (1 + c))| <= 0x18000000000000p-104 }
