# plucker_height (IS-3): The height is off by γ(n) of its terms without signs: a corner once, two edges of moved corners twice each, the products, and the sums.
# Of model/spec/src/rays/intersection/plucker.rs: 10 steps of n of γ(n), u = 2^-24.
{ |d1| <= 0x1p-24 /\ |d2| <= 0x1p-24 /\ |d3| <= 0x1p-24 /\ |d4| <= 0x1p-24 /\ |d5| <= 0x1p-24 /\ |d6| <= 0x1p-24 /\ |d7| <= 0x1p-24 /\ |d8| <= 0x1p-24 /\ |d9| <= 0x1p-24 /\ |d10| <= 0x1p-24 -> |(1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8) * (1 + d9) * (1 + d10) - 1| <= 0x140000c80007d1p-73 }
