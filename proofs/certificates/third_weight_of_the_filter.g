# third_weight_of_the_filter (IS-3): Of the third weight, what comes from the other two is off by so many L ε S D.
# Of model/fast/src/adaptive/bounds.rs: 69 steps of L ε S D.
u = U + eps * eu;
v = V + eps * ev;
{ eps in [0x13000000000000p-102, 0x14000000008000p-55]
  /\ |U| <= 0x1a222222222223p-49 /\ |V| <= 0x1a222222222223p-49
  /\ |eu| <= 0x10000000000000p-47 /\ |ev| <= 0x10000000000000p-47
  /\ |r1| <= 0x1p-53 /\ |r2| <= 0x1p-53
  -> |(u * (1 + r1) * (1 + r2) + v * (1 + r2) - (U + V)) / eps| <= 0x11400000000000p-46 }
(u * (1 + r1) * (1 + r2) + v * (1 + r2) - (U + V)) / eps -> U * (((1 + r1) * (1 + r2) - 1) / eps) + eu * ((1 + r1) * (1 + r2)) + V * (r2 / eps) + ev * (1 + r2) { eps <> 0 };
