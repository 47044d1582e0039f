# words_of_the_plane (IS-3): A word of the plane is off by so many ν, and the rounding of the quotient.
# Of model/fast/src/adaptive/bounds.rs: 5 steps of ν / 2.
{ nu in [0, 0x10000000000000p-56]
  /\ |P| <= 0x12222222222223p-52
  /\ |x| <= 1 /\ |y| <= 1
  /\ |d| <= 0x1p-53
  -> |(x - P * y) / (1 + nu * y) * (1 + d)| <= 0x14000000000000p-51 }
