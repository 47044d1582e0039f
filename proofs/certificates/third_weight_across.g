# third_weight_across (IS-3): Of the third weight, what comes from across is off by so many ε D.
# Of model/fast/src/adaptive/bounds.rs: 3.6 steps of ε D.
a = A + eps * ea;
{ eps in [0x13000000000000p-102, 0x14000000008000p-55]
  /\ |A| <= 0x1a222222222223p-51
  /\ |ea| <= 0x17333333333333p-51
  /\ |r1| <= 0x1p-53 /\ |r2| <= 0x1p-53
  -> |(a * (1 + r1) * (1 + r2) - A) / eps| <= 0x1ccccccccccccdp-51 }
(a * (1 + r1) * (1 + r2) - A) / eps -> A * (((1 + r1) * (1 + r2) - 1) / eps) + ea * ((1 + r1) * (1 + r2)) { eps <> 0 };
