// A U-core with a coil on one leg and a shading ring in the other, in mm. Change the numbers here or with -setnumber,
// then:
//   gmsh -2 -format msh41 u-core.geo -o u-core.msh
SetFactory("OpenCASCADE");
DefineConstant[
  gap = 1.5,      // between the pole faces, as drawn
  size = 2.2,     // of all triangles
  leg = 12,       // width of both legs
  window = 16,    // between the legs
  depth = 30,     // of the window
  yoke = 12,
  armature = 11,  // height
  ring = 2,       // width of the ring's section and of its slot
  slot = 3,       // depth of the slot
  shaded = 6,     // width of the pole inside the ring
  reach = 160     // of the air around
];
x1 = window / 2; x2 = x1 + leg;
pole = 0.25 * size; mid = 1 * size; inner = 1.5 * size; far = 3 * size; box = 24 * size;

// fixed iron, with the slot in the right leg
Point(1) = {-x2, -depth - yoke, 0, far};
Point(2) = {x2, -depth - yoke, 0, far};
Point(3) = {x2, 0, 0, pole};
Point(4) = {x2 - shaded / 2, 0, 0, mid};
Point(5) = {x2 - shaded, 0, 0, pole};
Point(6) = {x2 - shaded, -slot, 0, 2 * pole};
Point(7) = {x2 - shaded - ring, -slot, 0, 2 * pole};
Point(8) = {x2 - shaded - ring, 0, 0, pole};
Point(9) = {x1, 0, 0, pole};
Point(10) = {x1, -depth, 0, inner};
Point(11) = {-x1, -depth, 0, inner};
Point(12) = {-x1, 0, 0, pole};
Point(13) = {-x1 - leg / 2, 0, 0, mid};
Point(14) = {-x2, 0, 0, pole};
For k In {1 : 14}
  Line(k) = {k, k % 14 + 1};
EndFor
Curve Loop(1) = {1 : 14};
Plane Surface(1) = {1};

// the ring: in the slot, and along the outer flank of the leg
Rectangle(2) = {x2 - shaded - ring, -slot, 0, ring, slot};
Rectangle(3) = {x2, -slot, 0, ring, slot};

// the coil: between the legs, and outside of the left one
Rectangle(4) = {-x1 + 1, -depth + 2, 0, window - 5, depth - 5};
Rectangle(5) = {-x2 - 1 - (window - 5), -depth + 2, 0, window - 5, depth - 5};

// armature
Point(101) = {-x2, gap, 0, pole};
Point(102) = {-x1 - leg / 2, gap, 0, mid};
Point(103) = {-x1, gap, 0, 2 * pole};
Point(104) = {0, gap, 0, inner};
Point(105) = {x1, gap, 0, 2 * pole};
Point(106) = {x1 + leg / 2, gap, 0, mid};
Point(107) = {x2, gap, 0, pole};
Point(108) = {x2, gap + armature, 0, far};
Point(109) = {-x2, gap + armature, 0, far};
For k In {101 : 109}
  Line(k) = {k, k < 109 ? k + 1 : 101};
EndFor
Curve Loop(6) = {101 : 109};
Plane Surface(6) = {6};

// air around: all of it stretches
Point(121) = {-reach, -reach, 0, box};
Point(122) = {reach, -reach, 0, box};
Point(123) = {reach, reach, 0, box};
Point(124) = {-reach, reach, 0, box};
For k In {121 : 124}
  Line(k) = {k, k < 124 ? k + 1 : 121};
EndFor
Curve Loop(7) = {121 : 124};
Plane Surface(7) = {7};

all() = BooleanFragments{ Surface{7}; Delete; }{ Surface{1 : 6}; Delete; };
air() = all();
air() -= {1 : 6};
MeshSize{ PointsOf{ Surface{2, 3}; } } = pole;
MeshSize{ PointsOf{ Surface{4, 5}; } } = far;

Physical Surface("core") = {1};
Physical Surface("ring_in") = {2};
Physical Surface("ring_out") = {3};
Physical Surface("coil_in") = {4};
Physical Surface("coil_out") = {5};
Physical Surface("armature") = {6};
Physical Surface("air") = {air()};

e = 0.001;
rim() = Curve In BoundingBox{-reach - e, -reach - e, -1, -reach + e, reach + e, 1};
rim() += Curve In BoundingBox{reach - e, -reach - e, -1, reach + e, reach + e, 1};
rim() += Curve In BoundingBox{-reach - e, -reach - e, -1, reach + e, -reach + e, 1};
rim() += Curve In BoundingBox{-reach - e, reach - e, -1, reach + e, reach + e, 1};
Physical Curve("rim") = {rim()};
