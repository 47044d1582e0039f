# roundoff_of_f64 (IS-5): An operation in f64 rounds to its exact result times 1 + d, |d| at most u = 2^-53, from 2^-1021 on.
# Of model/fast/src/adaptive/bounds.rs: 1 steps of 2^-53.
@f64 = float<ieee_64, ne>;
{ |x| in [0x1p-1021, 0x1p+1023] -> |(f64(x) - x) / x| <= 0x10000000000000p-105 }
