// A pot magnet around the axis x = 0, in mm: a cup with a core, a coil in it, a disc above. Change the
// numbers here or with -setnumber, then:
//   gmsh -2 -format msh41 pot.geo -o pot.msh
SetFactory("OpenCASCADE");
DefineConstant[
  gap = 1.5,            // between the faces, as drawn
  size = 1.6,           // of all triangles
  core = 7,             // radius
  inner_radius = 16.5,  // of the cup's wall
  radius = 20,          // of cup and disc
  depth = 20,           // of the cup
  bottom = 5,
  disc = 5,             // height
  reach = 90            // of the air around
];
pole = 0.2 * size; mid = 0.8 * size; inner = 1.2 * size; far = 2 * size; box = 14 * size;

// cup and core
Point(1) = {0, -depth - bottom, 0, far};
Point(2) = {radius, -depth - bottom, 0, far};
Point(3) = {radius, 0, 0, pole};
Point(4) = {inner_radius, 0, 0, pole};
Point(5) = {inner_radius, -depth, 0, inner};
Point(6) = {core, -depth, 0, inner};
Point(7) = {core, 0, 0, pole};
Point(8) = {0, 0, 0, mid};
For k In {1 : 8}
  Line(k) = {k, k % 8 + 1};
EndFor
Curve Loop(1) = {1 : 8};
Plane Surface(1) = {1};

// coil
Rectangle(2) = {core + 0.8, -depth + 0.8, 0, inner_radius - core - 1.6, depth - 2};

// disc
Point(101) = {0, gap, 0, mid};
Point(102) = {core, gap, 0, 2 * pole};
Point(103) = {inner_radius, gap, 0, 2 * pole};
Point(104) = {radius, gap, 0, pole};
Point(105) = {radius, gap + disc, 0, far};
Point(106) = {0, gap + disc, 0, far};
For k In {101 : 106}
  Line(k) = {k, k < 106 ? k + 1 : 101};
EndFor
Curve Loop(3) = {101 : 106};
Plane Surface(3) = {3};

// air around: all of it stretches
Point(111) = {0, -reach, 0, box};
Point(112) = {reach, -reach, 0, box};
Point(113) = {reach, reach, 0, box};
Point(114) = {0, reach, 0, box};
For k In {111 : 114}
  Line(k) = {k, k < 114 ? k + 1 : 111};
EndFor
Curve Loop(4) = {111 : 114};
Plane Surface(4) = {4};

all() = BooleanFragments{ Surface{4}; Delete; }{ Surface{1 : 3}; Delete; };
air() = all();
air() -= {1 : 3};
MeshSize{ PointsOf{ Surface{2}; } } = far;

Physical Surface("cup") = {1};
Physical Surface("coil") = {2};
Physical Surface("disc") = {3};
Physical Surface("air") = {air()};

e = 0.001;
rim() = Curve In BoundingBox{reach - e, -reach - e, -1, reach + e, reach + e, 1};
rim() += Curve In BoundingBox{-e, -reach - e, -1, reach + e, -reach + e, 1};
rim() += Curve In BoundingBox{-e, reach - e, -1, reach + e, reach + e, 1};
Physical Curve("rim") = {rim()};
