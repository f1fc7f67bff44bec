// A rubber bushing on a steel sleeve, along z: radii 6, 8 and 20, length 24 millimetres. The mesh
// beside it was made by Gmsh 4.8.4:
//   gmsh -3 bushing.geo -o bushing.msh
radii[] = {6, 8, 20};
around = 4;  // cells in a quarter
layers[] = {1, 4};  growth[] = {1, 1.3};  // cells through the sleeve and through the rubber

Point(1) = {0, 0, 0};
For r In {0:2}
  For q In {0:3}
    Point(10 + 4 * r + q) = {radii[r] * Cos(q * Pi / 2), radii[r] * Sin(q * Pi / 2), 0};
  EndFor
  For q In {0:3}
    Circle(10 + 4 * r + q) = {10 + 4 * r + q, 1, 10 + 4 * r + (q + 1) % 4};
    Transfinite Curve{10 + 4 * r + q} = around + 1;
  EndFor
EndFor
For r In {0:1}
  For q In {0:3}
    Line(30 + 4 * r + q) = {10 + 4 * r + q, 14 + 4 * r + q};
    Transfinite Curve{30 + 4 * r + q} = layers[r] + 1 Using Progression growth[r];
  EndFor
  For q In {0:3}
    Curve Loop(50 + 4 * r + q) = {10 + 4 * r + q, 30 + 4 * r + (q + 1) % 4, -(14 + 4 * r + q), -(30 + 4 * r + q)};
    Plane Surface(50 + 4 * r + q) = {50 + 4 * r + q};
    Transfinite Surface{50 + 4 * r + q};
  EndFor
EndFor
sleeve[] = {};  rubber[] = {};  inside[] = {};  outside[] = {};
For q In {0:3}
  made[] = Extrude {0, 0, 24} { Surface{50 + q}; Layers{2}; };
  sleeve[] += made[1];  inside[] += made[2];
  made[] = Extrude {0, 0, 24} { Surface{54 + q}; Layers{2}; };
  rubber[] += made[1];  outside[] += made[4];
EndFor

Physical Volume("sleeve") = {sleeve[]};
Physical Volume("rubber") = {rubber[]};
Physical Surface("bolt") = {inside[]};  // the sleeve's inner face
Physical Surface("ring") = {outside[]};  // the rubber's outer face

Mesh.ElementOrder = 2;
Mesh.MshFileVersion = 4.1;
