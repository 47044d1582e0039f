# point_of_the_filter (IS-3): A coordinate of the point, times across, is off by so many ε S D.
# Of model/fast/src/adaptive/bounds.rs: 7.9 steps of ε S D.
a = A + eps * ea;
h = H + eps * eh;
X = f * A - H * d;
x = (f * (1 + s) * a * (1 + r1) - h * d * (1 + r2)) * (1 + r3);
{ eps in [0x13000000000000p-102, 0x14000000008000p-55]
  /\ |f| <= 1 /\ |d| <= 1
  /\ |A| <= 0x1a222222222223p-51 /\ |H| <= 0x1a222222222223p-51
  /\ |ea| <= 0x17333333333333p-51
  /\ |eh| <= 0x1999999999999ap-51
  /\ |s| <= 0x1p-53 /\ |r1| <= 0x1p-53 /\ |r2| <= 0x1p-53 /\ |r3| <= 0x1p-53
  -> |(x - X) / eps| <= 0x1f99999999999ap-50 }
(x - X) / eps -> f * A * (((1 + s) * (1 + r1) * (1 + r3) - 1) / eps) + f * ea * ((1 + s) * (1 + r1) * (1 + r3)) - H * d * (((1 + r2) * (1 + r3) - 1) / eps) - eh * d * ((1 + r2) * (1 + r3)) { eps <> 0 };
