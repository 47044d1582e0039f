# widening_absolute (KD-3): Where distances underflow, the width makes up for the roundings of the distance, of the widening and of the hit, half of 2^-149 each.
# Of model/spec/src/rays/interval.rs: 2 steps of 2^-149.
{ |a| <= 0x1p-150 /\ |b| <= 0x1p-150 /\ |c| <= 0x1p-150
  -> a * 0x1.00000cp+0 + b + c + 0x10000000000000p-200 >= 0 }
