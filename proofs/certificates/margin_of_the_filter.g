# margin_of_the_filter (IS-3): E, as computed with eight roundings, is no less than the error of any weight.
# Of model/fast/src/adaptive/bounds.rs: 70 steps of L ε D (S + 1/(8 L)).
{ |d1| <= 0x1p-53 /\ |d2| <= 0x1p-53 /\ |d3| <= 0x1p-53 /\ |d4| <= 0x1p-53 /\ |d5| <= 0x1p-53 /\ |d6| <= 0x1p-53 /\ |d7| <= 0x1p-53 /\ |d8| <= 0x1p-53
  -> 70 * ((1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8)) >= 0x11400000000000p-46 /\ 70 * 0.125 * ((1 + d1) * (1 + d2) * (1 + d3) * (1 + d4) * (1 + d5) * (1 + d6) * (1 + d7) * (1 + d8)) >= 0x1ccccccccccccdp-51 }
