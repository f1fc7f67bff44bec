// A steel bracket: a plate against the wall, a shelf on it, a rib between them, and holes for two
// bolts and a hook. Millimetres. The mesh beside it was made by Gmsh 4.8.4:
//   gmsh -3 bracket.geo -o bracket.msh
SetFactory("OpenCASCADE");

Box(1) = {0, -25, 0, 8, 50, 70};          // plate
Box(2) = {8, -25, 62, 72, 50, 8};         // shelf
Point(101) = {8, -4, 14};  Point(102) = {8, -4, 62};  Point(103) = {58, -4, 62};
Line(101) = {101, 102};  Line(102) = {102, 103};  Line(103) = {103, 101};
Curve Loop(101) = {101, 102, 103};
Plane Surface(101) = {101};
rib[] = Extrude {0, 8, 0} { Surface{101}; };
body[] = BooleanUnion{ Volume{1}; Delete; }{ Volume{2, rib[1]}; Delete; };
Cylinder(11) = {-1, -15, 22, 10, 0, 0, 4.5};
Cylinder(12) = {-1, 15, 22, 10, 0, 0, 4.5};
Cylinder(13) = {68, 0, 61, 0, 0, 10, 6};
all[] = BooleanDifference{ Volume{body[]}; Delete; }{ Volume{11, 12, 13}; Delete; };

e = 1e-3;
Physical Volume("steel") = {all[]};
Physical Surface("wall") = Surface In BoundingBox {-e, -25 - e, -e, e, 25 + e, 70 + e};
Physical Surface("shelf") = Surface In BoundingBox {-e, -25 - e, 70 - e, 80 + e, 25 + e, 70 + e};
Physical Surface("bolts") = Surface In BoundingBox {-e, -20 - e, 17, 8 + e, 20 + e, 27};
Physical Surface("hook") = Surface In BoundingBox {61, -7, 62 - e, 75, 7, 70 + e};

Mesh.CharacteristicLengthMax = 12;
Mesh.CharacteristicLengthFromCurvature = 1;
Mesh.MinimumElementsPerTwoPi = 9;
Mesh.ElementOrder = 2;
Mesh.MshFileVersion = 4.1;
