# normal_rounded_edges (IS-3): With edges that are rounded, it is off by so much of the sum of both products without signs.
# Of model/fast/src/adaptive/bounds.rs: 3 steps of u, 2^-53.
{ |e| <= 0x1p-53 /\ |f| <= 0x1p-53
  -> |(1 + e) * (1 + f) - 1| * (1 + 0x3p-53) + 0x10000000000000p-155 <= 0x18000000000000p-104 }
