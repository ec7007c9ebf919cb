MODULE m
CONST robtarget p1:=[[1500,20,1200],[0.7,0,0.7,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST jointtarget j1:=[[50,-100,80,-25,-53,72],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveJ p1,v100,fine,tool0;
MoveAbsJ j1,v100,fine,tool0;
ENDPROC
ENDMODULE
