# roundings_within_epsilon (IS-3): Three times three roundings are within ε, of which this is the part beside ν.
# Of model/fast/src/adaptive/bounds.rs: 2 steps of u, 2^-53.
{ |a| <= 0x1p-53 /\ |b| <= 0x1p-53 /\ |c| <= 0x1p-53
  -> 3 * |(1 + a) * (1 + b) * (1 + c) - 1| <= 0x13000000000000p-102 }
