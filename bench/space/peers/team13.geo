// TEAM workshop problem 13, the half z >= 0, for gmsh. Lengths in mm, mesh in m. `size` scales the cells near the plates.
SetFactory("OpenCASCADE");
DefineConstant[ size = {1, Name "size"} ];

// bodies
Box(1) = {-1.6, -25, 0, 3.2, 50, 63.2};
Box(2) = {2.1, 15, 60, 120, 50, 3.2};
Box(3) = {122.1, 15, 0, 3.2, 50, 63.2};
Box(4) = {-122.1, -65, 60, 120, 50, 3.2};
Box(5) = {-125.3, -65, 0, 3.2, 50, 63.2};
Rectangle(1001) = {-100, -100, 0, 200, 200, 50};
Rectangle(1002) = {-75, -75, 0, 150, 150, 25};
outer() = Extrude {0, 0, 50} { Surface{1001}; };
inner() = Extrude {0, 0, 50} { Surface{1002}; };
Box(20) = {-1000, -1000, 0, 2000, 2000, 1000};
parts() = BooleanFragments{ Volume{20}; Delete; }{ Volume{1, 2, 3, 4, 5, outer(1), inner(1)}; Delete; };

// groups by their bounding boxes
e = 0.01;
steel() = Volume In BoundingBox{-1.6 - e, -25 - e, -e, 1.6 + e, 25 + e, 63.2 + e};
steel() += Volume In BoundingBox{2.1 - e, 15 - e, -e, 125.3 + e, 65 + e, 63.2 + e};
steel() += Volume In BoundingBox{-125.3 - e, -65 - e, -e, -2.1 + e, -15 + e, 63.2 + e};
opening() = Volume In BoundingBox{-75 - e, -75 - e, -e, 75 + e, 75 + e, 50 + e};
opening() -= steel();
coil() = Volume In BoundingBox{-100 - e, -100 - e, -e, 100 + e, 100 + e, 50 + e};
coil() -= opening(); coil() -= steel();
air() = Volume{:};
air() -= steel(); air() -= coil(); air() -= opening();
Physical Volume("steel", 1) = steel();
Physical Volume("coil", 2) = coil();
Physical Volume("air", 3) = air();
Physical Volume("opening", 4) = opening();
far() = {};
rim() = CombinedBoundary{ Volume{:}; };
For k In {0 : #rim() - 1}
  box() = BoundingBox Surface{rim(k)};
  If (box(5) > 1)  // not in the plane z = 0
    far() += rim(k);
  EndIf
EndFor
Physical Surface("far", 10) = far();

// sizes: edges of the plates, their inside, the gaps
faces() = Boundary{ Volume{steel()}; };
Field[1] = Distance; Field[1].CurvesList = {Boundary{ Surface{faces()}; }}; Field[1].NumPointsPerCurve = 100;
Field[2] = Threshold; Field[2].InField = 1;
Field[2].SizeMin = 1.0 * size; Field[2].SizeMax = 120; Field[2].DistMin = 0.5; Field[2].DistMax = 350;
For k In {0 : 1}
  sign = 1 - 2 * k;
  Field[3 + k] = Box; Field[3 + k].VIn = 0.5 * size; Field[3 + k].VOut = 120; Field[3 + k].Thickness = 8;
  Field[3 + k].XMin = (k == 0) ? 0.9 : -2.9; Field[3 + k].XMax = (k == 0) ? 2.9 : -0.9;
  Field[3 + k].YMin = (k == 0) ? 14 : -26; Field[3 + k].YMax = (k == 0) ? 26 : -14;
  Field[3 + k].ZMin = 59; Field[3 + k].ZMax = 64;
EndFor
Field[7] = MathEval; Field[7].F = Sprintf("%g", 4 * size);
Field[5] = Restrict; Field[5].InField = 7; Field[5].VolumesList = {steel()};
Field[6] = Min; Field[6].FieldsList = {2, 3, 4, 5};
Background Field = 6;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0; Mesh.MeshSizeMax = 120;
Mesh.Algorithm3D = 10; Mesh.ScalingFactor = 0.001; Mesh.Optimize = 1;
