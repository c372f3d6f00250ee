// The right half of an E-core with a flat armature, in mm. Change the numbers here or with -setnumber, then:
//   gmsh -2 -format msh41 e-core.geo -o e-core.msh
SetFactory("OpenCASCADE");
DefineConstant[
  gap = 1.5,      // between the pole faces, as drawn
  size = 1.6,     // of all triangles
  centre = 8,     // half of the centre leg
  window = 10,    // between the legs
  outer = 8,      // outer leg
  depth = 22,     // of the window
  yoke = 8,
  armature = 9,   // height
  reach = 110     // of the air around
];
x1 = centre; x2 = x1 + window; x3 = x2 + outer;
pole = 0.2 * size; mid = 0.8 * size; inner = 1.2 * size; far = 2.4 * size; box = 16 * size;

// fixed iron
Point(1) = {0, -depth - yoke, 0, far};
Point(2) = {x3, -depth - yoke, 0, far};
Point(3) = {x3, 0, 0, pole};
Point(4) = {x2 + outer / 2, 0, 0, mid};
Point(5) = {x2, 0, 0, pole};
Point(6) = {x2, -depth, 0, inner};
Point(7) = {x1, -depth, 0, inner};
Point(8) = {x1, 0, 0, pole};
Point(9) = {0, 0, 0, mid};
For k In {1 : 9}
  Line(k) = {k, k % 9 + 1};
EndFor
Curve Loop(1) = {1 : 9};
Plane Surface(1) = {1};

// armature
Point(11) = {0, gap, 0, mid};
Point(12) = {x1, gap, 0, 2 * pole};
Point(13) = {(x1 + x2) / 2, gap, 0, inner};
Point(14) = {x2, gap, 0, 2 * pole};
Point(15) = {x2 + outer / 2, gap, 0, mid};
Point(16) = {x3, gap, 0, pole};
Point(17) = {x3, gap + armature, 0, far};
Point(18) = {0, gap + armature, 0, far};
For k In {11 : 18}
  Line(k) = {k, k < 18 ? k + 1 : 11};
EndFor
Curve Loop(2) = {11 : 18};
Plane Surface(2) = {2};

// coil
Point(21) = {x1 + 1, -depth + 1.5, 0, far};
Point(22) = {x2 - 1, -depth + 1.5, 0, far};
Point(23) = {x2 - 1, -1.5, 0, inner};
Point(24) = {x1 + 1, -1.5, 0, inner};
For k In {21 : 24}
  Line(k) = {k, k < 24 ? k + 1 : 21};
EndFor
Curve Loop(3) = {21 : 24};
Plane Surface(3) = {3};

// the layer that stretches goes from the mirror line to the outer edge: the air above it moves with the armature
Point(31) = {x3, 0, 0, pole};
Point(32) = {reach, 0, 0, box};
Point(33) = {reach, gap, 0, box};
Point(34) = {0, gap, 0, mid};
Point(35) = {0, 0, 0, mid};
For k In {31 : 35}
  Line(k) = {k, k < 35 ? k + 1 : 31};
EndFor
Curve Loop(4) = {31 : 35};
Plane Surface(4) = {4};

// air around
Point(41) = {0, -reach, 0, box};
Point(42) = {reach, -reach, 0, box};
Point(43) = {reach, reach, 0, box};
Point(44) = {0, reach, 0, box};
For k In {41 : 44}
  Line(k) = {k, k < 44 ? k + 1 : 41};
EndFor
Curve Loop(5) = {41 : 44};
Plane Surface(5) = {5};

all() = BooleanFragments{ Surface{5}; Delete; }{ Surface{1 : 4}; Delete; };
air() = all();
air() -= {1 : 4};

// a shape keeps its number; what is new is air
Physical Surface("core") = {1};
Physical Surface("armature") = {2};
Physical Surface("coil") = {3};
Physical Surface("layer") = {4};
Physical Surface("air") = {air()};

e = 0.001;
rim() = Curve In BoundingBox{-e, -reach - e, -1, e, reach + e, 1};
rim() += Curve In BoundingBox{-e, -reach - e, -1, reach + e, -reach + e, 1};
rim() += Curve In BoundingBox{-e, reach - e, -1, reach + e, reach + e, 1};
rim() += Curve In BoundingBox{reach - e, -reach - e, -1, reach + e, reach + e, 1};
Physical Curve("rim") = {rim()};
