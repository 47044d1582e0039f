# roundoff_of_f32 (IS-5): An operation in f32 rounds to its exact result times 1 + d, |d| at most u = 2^-24, from 2^-125 on.
# Of reference/oracles/src/formats.rs: 1 steps of 2^-24.
@f32 = float<ieee_32, ne>;
{ |x| in [0x1p-125, 0x1p+127] -> |(f32(x) - x) / x| <= 0x10000000000000p-76 }
