# watertight_shear (IS-1): A sheared coordinate is off by γ(n) of its terms without signs: a difference, the quotient, their product, and the subtraction.
# Of model/spec/src/rays/intersection/watertight.rs: 4 steps of n of γ(n), u = 2^-24.
{ |d1| <= 0x1p-24 /\ |d2| <= 0x1p-24 /\ |d3| <= 0x1p-24 /\ |d4| <= 0x1p-24 -> |(1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) - 1| <= 0x10000040000101p-74 }
