# slope_of_an_owned_edge (IS-6): A slope of a weight, the difference of two products with rounded differences, is off by so many u of their sum without signs, as computed.
# Of model/fast/src/adaptive/bounds.rs: 4 steps of u, 2^-53.
{ |a| <= 0x1p-53 /\ |b| <= 0x1p-53 /\ |f| <= 0x1p-53 /\ |g| <= 0x1p-53
  -> |(1 + a) * (1 + b) * (1 + f) - 1| / ((1 + a) * (1 + b) * (1 + g)) <= 0x10000000000000p-103 }
