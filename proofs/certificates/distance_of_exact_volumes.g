# distance_of_exact_volumes (IS-3): A quotient of two numbers, of which each and itself are rounded once, is off by so many u of itself as computed.
# Of model/fast/src/adaptive/bounds.rs: 4 steps of u, 2^-53.
{ |a| <= 0x1p-53 /\ |b| <= 0x1p-53 /\ |c| <= 0x1p-53
  -> |(1 + a) * (1 + c) / (1 + b) - 1| / ((1 + a) * (1 + c) / (1 + b)) <= 0x10000000000000p-103 }
