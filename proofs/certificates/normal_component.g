# normal_component (IS-3): A component of the normal, a difference of two products with their errors added, is off by so much of itself, beside what it is of the products.
# Of model/fast/src/adaptive/bounds.rs: 3 steps of u, 2^-53.
{ |a| <= 0x1p-53 /\ |c| <= 0x1p-53
  -> |(1 + a) * (1 + c) - 1| <= 0x18000000000000p-104 }
