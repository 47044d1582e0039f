# words_of_the_weights (IS-3): A word of the weights, a rounded edge over a component of the normal, is off by so many ν of itself.
# Of model/fast/src/adaptive/bounds.rs: 4 steps of ν / 2.
{ eps in [0x18000000000000p-104, 0x10000000000000p-56]
  /\ |y| <= 1
  /\ |a| <= 0x1p-53 /\ |b| <= 0x1p-53
  -> |((1 + a) * (1 + b) / (1 + eps * y) - 1) / eps| <= 0x10000000000000p-51 }
((1 + a) * (1 + b) / (1 + eps * y) - 1) / eps -> (((1 + a) * (1 + b) - 1) / eps - y) / (1 + eps * y) { eps <> 0 };
