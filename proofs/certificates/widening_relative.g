# widening_relative (KD-3): A widened distance is beyond every f32 that is reported at 1 - 2u to 1 + 2u times the true one, to either side.
# Of model/spec/src/rays/interval.rs: 5 steps of 2^-24 / (1 - 3 2^-24), in f32.
{ |d1| <= 0x1p-24 /\ |d2| <= 0x1p-24 /\ |d3| <= 0x1p-24
  -> (1 + d1) * (1 + d2) * (1 + d3) * 0x1fffff60000000p-53 <= 0x0.fffffep+0 /\ (1 + d1) * (1 + d2) * (1 + d3) * 0x10000060000000p-52 >= 0x1.000002p+0 }
